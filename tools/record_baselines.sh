#!/usr/bin/env bash
# All that is recorded of this version, anew, in one go: the sample's streams (tests/golden) and the instructions a frame by stage
# (tests/budget/instructions.json). After a change of the estimator that was meant; say in the commit what moved and why.
#   tools/record_baselines.sh
# For the architecture that it is called on; arm64's stream is recorded under QEMU by tools/check_arm64.sh record.
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,5s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
tools/build.sh release
.venv/bin/python tools/golden.py record
.venv/bin/python tools/instruction_counts.py record
git --no-pager diff --stat -- tests/golden tests/budget/instructions.json
