#!/usr/bin/env bash
# Configures and builds one preset (default: release), with a compiler cache where there is one.
#   tools/build.sh [PRESET [TARGET]...]
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,3s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
PRESET=${1:-release}
targets=("${@:2}")

# The solvers' headers take about 1.5 GB a compiler: as many at a time as there is memory for, not only as many as cores.
jobs() {
  local by_memory cores
  by_memory=$(awk '/MemAvailable/ { print int($2 / 1572864) }' /proc/meminfo)
  cores=$(nproc)
  echo $((by_memory < 1 ? 1 : by_memory < cores ? by_memory : cores))
}

cache=()
if command -v ccache >/dev/null; then
  cache=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
printf '== build: %s%s\n' "$PRESET" "${targets:+ ${targets[*]}}"
log=$(cmake --preset "$PRESET" "${cache[@]}" 2>&1) || { printf "%s\n" "$log" >&2; exit 1; }
cmake --build --preset "$PRESET" -j "$(jobs)" ${targets:+--target "${targets[@]}"}
