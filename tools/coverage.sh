#!/usr/bin/env bash
# How much of fsw its tests in C++ take: lines and branches of its units, by stage. The preset `coverage`, ctest and gcovr.
#   tools/coverage.sh [STAGE]...     only of these stages, by the tests of these stages; without, of all of them
# Nothing is optimised: six of the stages take some ten minutes on two cores, all of them hours. Set up once by tools/setup.sh extras.
set -euo pipefail
cd "$(dirname "$0")/.."
BUILD=build/coverage
STAGES=(base geometry solve image mask features tracks initialisation map shape motion bus pipeline)
case ${1:-} in -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;; esac
stages=("$@")
[ $# -gt 0 ] || stages=("${STAGES[@]}")
for stage in "${stages[@]}"; do
  case " ${STAGES[*]} " in
    *" $stage "*) ;;
    *) echo "coverage: unknown stage '$stage'; allowed: ${STAGES[*]}" >&2; exit 2 ;;
  esac
done
.venv/bin/python -m gcovr --version >/dev/null 2>&1 || { echo "coverage: gcovr is not installed; tools/setup.sh extras installs it" >&2; exit 2; }

tools/build.sh coverage "${stages[@]/#/test_}"
find "$BUILD" -name '*.gcda' -delete
for stage in "${stages[@]}"; do
  printf '== tests of %s\n' "$stage"
  "$BUILD/bin/test_$stage" --gtest_brief=1
done

printf '== coverage by the tests of %s\n' "${stages[*]}"
# Left out: branches that only an exception takes, those that the compiler made and nothing reaches, and those of assertions, which no
# test may take and go on. Headers are left out, as each test has a copy of its own.
.venv/bin/python -m gcovr --root . --object-directory "$BUILD/fsw" --filter "fsw/($(IFS='|'; echo "${stages[*]}"))/.*\.cpp\$" --exclude-throw-branches \
  --exclude-unreachable-branches --exclude-lines-by-pattern '.*POLHODE_ASSERT.*' --gcov-ignore-parse-errors=suspicious_hits.warn \
  --json-summary "$BUILD/coverage.json" "${stages[@]/#/$BUILD/fsw/}" >/dev/null
exec .venv/bin/python tools/coverage_table.py "$BUILD/coverage.json"
