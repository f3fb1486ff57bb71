#!/usr/bin/env bash
# How much of fsw its tests in C++ take: lines and branches of its units by stage, by the stage's own tests and then by the pipeline's, too.
#   tools/coverage.sh [STAGE]...     only of these stages, by their own tests; without, of all of them: more than an hour on two cores
# Only the stages are compiled for counting, without optimisation (tests/coverage.cmake). Set up once by tools/setup.sh extras.
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
cd "$(dirname "$0")/.."
BUILD=build/release
OUT=build/coverage
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

# Left out: branches that only an exception takes, those that the compiler made and nothing reaches, and those of assertions, which no
# test may take and go on. Headers are left out, as each test has a copy of its own.
summary() {
  .venv/bin/python -m gcovr --root . --object-directory "$BUILD/tests" --filter "fsw/($(IFS='|'; echo "${stages[*]}"))/.*\.cpp\$" \
    --exclude-throw-branches --exclude-unreachable-branches --exclude-lines-by-pattern '.*POLHODE_ASSERT.*' \
    --gcov-ignore-parse-errors=suspicious_hits.warn --json-summary "$1" "${objects[@]}" >/dev/null
  .venv/bin/python tools/coverage_table.py "$1"
}

tests=()
objects=()
for stage in "${stages[@]}"; do
  objects+=("$BUILD/tests/CMakeFiles/counted_$stage.dir")
  case $stage in
    pipeline) ;;
    solve) tests+=(solve solve_start) ;;
    *) tests+=("$stage") ;;
  esac
done
with_pipeline=no
case " ${stages[*]} " in *" pipeline "*) with_pipeline=yes ;; esac
targets=("${tests[@]/#/counted_test_}")
[ $with_pipeline = no ] || targets+=(counted_test_pipeline)
tools/build.sh release "${targets[@]}"
mkdir -p "$OUT"
for stage in "${STAGES[@]}"; do
  [ ! -d "$BUILD/tests/CMakeFiles/counted_$stage.dir" ] || find "$BUILD/tests/CMakeFiles/counted_$stage.dir" -name '*.gcda' -delete
done
for test in "${tests[@]}"; do
  printf '== tests of %s\n' "$test"
  "$BUILD/bin/counted_test_$test" --gtest_brief=1
done
printf '== coverage by the own tests of %s\n' "${stages[*]}"
summary "$OUT/own.json"
[ $with_pipeline = yes ] || exit 0
printf '== tests of the pipeline\n'
"$BUILD/bin/counted_test_pipeline" --gtest_brief=1
printf '== coverage with those of the pipeline\n'
summary "$OUT/all.json"
