#!/usr/bin/env bash
# Builds for arm64, the architecture of the computers it flies on, and runs that under QEMU: the unit tests of what may depend on
# the architecture, and the sample on two processors, whose streams are compared with tests/golden/aarch64.
#   tools/check_arm64.sh [record]     record: the sample's stream anew, after a change of the estimator that was meant
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
cd "$(dirname "$0")/.."
TESTS=(base region geometry solve image features tracks bus transport)
BUILD=build/flight-aarch64
MODE=${1:-check}
case $MODE in
  check | record) ;;
  -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;;
  *) echo "check_arm64: unknown argument '$1'; allowed: record, or nothing" >&2; exit 2 ;;
esac

tools/setup.sh arm64
tools/build.sh flight-aarch64 polhode "${TESTS[@]/#/test_}"
ctest --test-dir "$BUILD" --output-on-failure -j "$(nproc)" -R "^($(IFS='|'; echo "${TESTS[*]}"))\."

export POLHODE_PROGRAM=$PWD/$BUILD/bin/polhode
POLHODE_RUNNER=$(sed -n 's/^POLHODE_RUNNER:STRING=//p' "$BUILD/CMakeCache.txt")
export POLHODE_RUNNER
printf '== the sample, in three configurations, five minutes each\n'
python3 tools/golden.py "$MODE"
printf '== again on a processor that has all that the emulator knows\n'
POLHODE_RUNNER=${POLHODE_RUNNER/cortex-a53/max} exec python3 tools/golden.py check
