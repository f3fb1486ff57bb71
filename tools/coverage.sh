#!/usr/bin/env bash
# How much of fsw its tests in C++ take: lines and branches of its units, by stage. The preset `coverage`, ctest and gcovr.
#   tools/coverage.sh [FOLDER]...     only by the tests of these folders of tests/; without, by those of every stage
# Nothing is optimised: all of it takes hours on two cores. Set up once by tools/setup.sh extras.
set -euo pipefail
cd "$(dirname "$0")/.."
BUILD=build/coverage
STAGES=(base geometry solve image mask features tracks initialisation map shape motion bus pipeline)
case ${1:-} in -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;; esac
folders=("$@")
[ $# -gt 0 ] || folders=("${STAGES[@]}")
for folder in "${folders[@]}"; do
  case " ${STAGES[*]} " in
    *" $folder "*) ;;
    *) echo "coverage: unknown folder '$folder'; allowed: ${STAGES[*]}" >&2; exit 2 ;;
  esac
done
.venv/bin/python -m gcovr --version >/dev/null 2>&1 || { echo "coverage: gcovr is not installed; tools/setup.sh extras installs it" >&2; exit 2; }

tools/build.sh coverage "${STAGES[@]/#/polhode_}" "${folders[@]/#/test_}"
find "$BUILD" -name '*.gcda' -delete
for folder in "${folders[@]}"; do
  printf '== tests of %s\n' "$folder"
  "$BUILD/bin/test_$folder" --gtest_brief=1
done

printf '== coverage by the tests of %s\n' "${folders[*]}"
# Left out: branches that only an exception takes, those that the compiler made and nothing reaches, and those of assertions, which no
# test may take and go on. Headers are left out, as each test has a copy of its own.
.venv/bin/python -m gcovr --root . --object-directory "$BUILD/fsw" --filter 'fsw/.*\.cpp$' --exclude-throw-branches \
  --exclude-unreachable-branches --exclude-lines-by-pattern '.*POLHODE_ASSERT.*' --gcov-ignore-parse-errors=suspicious_hits.warn \
  --json-summary "$BUILD/coverage.json" "$BUILD/fsw" >/dev/null
exec .venv/bin/python tools/coverage_table.py "$BUILD/coverage.json"
