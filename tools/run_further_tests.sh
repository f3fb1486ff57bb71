#!/usr/bin/env bash
# The tests that tools/run_tests.sh leaves out, since they need what takes long to install or to build: COLMAP, Rerun, evo, Doxygen and Sphinx,
# a browser, Debian packages of this tree, the arm64 compiler, a YAMCS server; campaigns on schedulers, which take minutes; and long cases of
# everyday tests. Ends with one line of totals.
#   tools/run_further_tests.sh [-k FILTER]
# With POLHODE_TEMPLE_RING=SEQ the photographs that may not be redistributed are tried, too (CONTRIBUTING.md).
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,6s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
REPORTS=build/test-reports

reports=("$REPORTS/further.xml")
pytest_arguments=(-ra --durations=5 -m further -n "$(nproc)" --dist loadfile --junitxml "$REPORTS/further.xml")
if [ $# -gt 0 ]; then
  [ "$1" = -k ] && [ $# -eq 2 ] || { echo "run_further_tests: unknown argument '$1'; allowed: -k FILTER" >&2; exit 2; }
  pytest_arguments+=(-k "$2")
fi

for part in tests extras colmap site packages arm64 browser; do
  tools/setup.sh "$part"
done
tools/build.sh release
mkdir -p "$REPORTS"
rm -f "$REPORTS/further.xml" "$REPORTS/ground_station.xml"
status=0
if [ $# -eq 0 ]; then
  printf '== packages for the tests of packages\n'
  tools/package.sh
fi
printf '== tests in Python\n'
.venv/bin/python -m pytest tests "${pytest_arguments[@]}" || [ $? -eq 5 ] || status=1
if [ $# -eq 0 ]; then
  printf '== ground station\n'
  hil/test_ground_station.sh --junitxml "$REPORTS/ground_station.xml" || status=1
  reports+=("$REPORTS/ground_station.xml")
fi
printf '== totals\n'
.venv/bin/python tools/junit_totals.py "${reports[@]}" || status=1
exit $status
