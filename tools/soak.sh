#!/usr/bin/env bash
# The long memory test: 20,000 frames after the seal (the everyday suite takes 300).
#   tools/soak.sh [FRAMES]
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,3s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
export POLHODE_SOAK_FRAMES=${1:-20000}
tools/build.sh release
exec .venv/bin/python -m pytest tests/memory -ra
