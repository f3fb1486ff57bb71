#!/usr/bin/env bash
# What a frame costs on this machine: the sample as it is and at 1080p, stage by stage. Worth something on a quiet machine.
#   tools/benchmark.sh [CONFIG.toml] [--set key=value ...]
set -euo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,3s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
CONFIG=config/default.toml
if [ $# -gt 0 ] && [ "${1#--}" = "$1" ]; then
  CONFIG=$1
  shift
fi
WORK=build/benchmark
SAMPLE=hil/data/sample
mkdir -p "$WORK"
[ -d "$WORK/1080p" ] || .venv/bin/python tools/scale_sequence.py "$SAMPLE" "$WORK/1080p" --width 1920 --height 1080

for size in 640x480 1080p; do
  sequence=$SAMPLE
  [ $size = 640x480 ] || sequence=$WORK/1080p
  build/release/bin/polhode replay --config "$CONFIG" --sequence "$sequence" --out "$WORK/run-$size" "$@" >/dev/null
  printf '== %s, %s\n' "$size" "$CONFIG"
  .venv/bin/python tools/benchmark_table.py "$WORK/run-$size/summary.json"
done
printf 'load of the machine: %s on %s cores\n' "$(cut -d' ' -f1 /proc/loadavg)" "$(nproc)"
