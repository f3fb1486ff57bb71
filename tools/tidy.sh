#!/usr/bin/env bash
# clang-tidy over the C++ of fsw and platform, by .clang-tidy.
#   tools/tidy.sh            what the last commit changed, and what is not committed
#   tools/tidy.sh --list     names those files and checks nothing
#   tools/tidy.sh --all      everything: ten to thirty minutes on two cores
#   tools/tidy.sh FILE...
set -euo pipefail
cd "$(dirname "$0")/.."
# Of its own: each file by itself, without the headers that are parsed ahead, so that a missing include is found.
DATABASE=build/tidy

list=false
if [ "${1:-}" = --list ]; then
  list=true
  shift
fi
case ${1:-} in
  -h | --help) sed -n '2,6s/^# //p' "$0"; exit 0 ;;
  --all) mapfile -t files < <(git ls-files 'fsw/*.cpp' 'platform/*.cpp') ;;
  -*) echo "tidy: unknown argument '$1'; allowed: --list, --all, files" >&2; exit 2 ;;
  "")
    mapfile -t files < <(
      { git diff --name-only HEAD; git diff --name-only HEAD~1 HEAD 2>/dev/null || true; } |
        grep -E '^(fsw|platform)/.*\.cpp$' | sort -u | while read -r file; do if [ -f "$file" ]; then echo "$file"; fi; done) ;;
  *) files=("$@") ;;
esac
if $list; then
  printf '%s\n' "${files[@]}"
  exit 0
fi
if ! command -v clang-tidy >/dev/null; then
  echo "tidy: clang-tidy is not installed; tools/setup.sh tests installs it" >&2
  exit 2
fi
if [ ${#files[@]} -eq 0 ]; then
  echo "tidy: no file has changed"
  exit 0
fi
log=$(cmake --preset release -B "$DATABASE" -DPOLHODE_TESTS=OFF -DCMAKE_UNITY_BUILD=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON 2>&1) || { echo "$log" >&2; exit 2; }
sed -i 's/ -fno-tree-[a-z-]*//g' "$DATABASE/compile_commands.json"  # options of g++ that clang does not know
printf '== clang-tidy: %d files\n' "${#files[@]}"
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy -p "$DATABASE" --quiet \
  --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-ignored-optimization-argument \
  --extra-arg=-Wno-unused-command-line-argument
