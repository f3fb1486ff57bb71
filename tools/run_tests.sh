#!/usr/bin/env bash
# Set-up, build and all tests: those in C++ by ctest, those in Python by pytest. Ends with one line of totals.
#   tools/run_tests.sh [-k FILTER] [--quick]
#   -k FILTER  only tests whose name holds FILTER        --quick  without the tests that are marked slow
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
cd "$(dirname "$0")/.."
BUILD=build/release
REPORTS=build/test-reports

filter=
quick=false
while [ $# -gt 0 ]; do
  case $1 in
    -k) filter=${2:?run_tests: -k needs a filter}; shift 2 ;;
    --quick) quick=true; shift ;;
    -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;;
    *) echo "run_tests: unknown argument '$1'; allowed: -k FILTER, --quick" >&2; exit 2 ;;
  esac
done

ctest_arguments=(--test-dir "$BUILD" --output-on-failure --no-tests=ignore -j "$(nproc)")
# The tests of a file run one after another: they share what they have made, and its ports are theirs.
# One more than cores: tests of live runs wait for most of their time.
pytest_arguments=(-ra --durations=30 -n "$(($(nproc) + 1))" --dist loadfile --no-loadscope-reorder)
marks="not further"
if [ -n "$filter" ]; then
  ctest_arguments+=(-R "$filter")
  pytest_arguments+=(-k "$filter")
fi
if $quick; then
  ctest_arguments+=(-LE slow)
  marks="$marks and not slow"
fi

mkdir -p "$REPORTS"
tools/setup.sh tests
tools/setup.sh renderer > "$REPORTS/renderer.log" 2>&1 &  # the build needs none of it
renderer=$!
trap 'kill "$renderer" 2>/dev/null || true' EXIT
tools/build.sh release
wait "$renderer" || { cat "$REPORTS/renderer.log" >&2; exit 1; }

rm -f "$REPORTS"/ctest.xml "$REPORTS"/pytest.xml
status=0
printf '== tests in C++\n'
ctest "${ctest_arguments[@]}" --output-junit "$PWD/$REPORTS/ctest.xml" || status=1
printf '== tests in Python\n'
# 5: the filter leaves no test on this side
.venv/bin/python -m pytest tests -m "$marks" "${pytest_arguments[@]}" --junitxml "$REPORTS/pytest.xml" || [ $? -eq 5 ] || status=1

if [ -z "$filter" ] && ! $quick; then
  printf '== requirements that are not verified\n'
  tools/requirements_matrix.py --open || status=1
fi

printf '== totals\n'
.venv/bin/python tools/junit_totals.py "$REPORTS"/ctest.xml "$REPORTS"/pytest.xml || status=1
exit $status
