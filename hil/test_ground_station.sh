#!/usr/bin/env bash
# Tests of the ground station: a YAMCS server takes a replay's stream, a browser shows it. In a network of its own, so that the
# server's ports are nobody else's. Takes two minutes, and the first time 60 MB from Maven Central and Debian's browser.
#   hil/test_ground_station.sh [arguments of pytest]
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."

hil/ground_station.sh --install
tools/setup.sh tests
tools/setup.sh browser
POLHODE_GROUND_STATION=1 exec unshare -n sh -c 'ip link set lo up && exec .venv/bin/python -m pytest tests/ground_station "$@"' sh "$@"
