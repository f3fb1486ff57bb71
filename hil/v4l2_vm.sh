#!/usr/bin/env bash
# The camera's path through a real kernel, in a virtual machine: capture, the live run and its faults.
#   hil/v4l2_vm.sh [JOB]...     one or more of hil/v4l2/jobs/*.sh; without, all of them
# Sets up what it needs (hil/v4l2/setup_vm.sh). The program under test is the host's own build/release.
set -uo pipefail
unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1  # packages of another Python would hide the project's
case ${1:-} in -h | --help) sed -n '2,4s/^# //p' "$0"; exit 0 ;; esac
cd "$(dirname "$0")/.."
RESULTS=build/v4l2_vm/results
TIMEOUT_S=${POLHODE_VM_TIMEOUT_S:-1800}

# The guest has its own memory at /run and /tmp, where the host's files do not show.
case $(pwd -P)/ in
  /tmp/* | /run/*) echo "v4l2_vm: $(pwd -P): lies below /tmp or /run, where the guest has memory of its own; use a clone elsewhere" >&2; exit 2 ;;
esac
for program in polhode filecam_feed; do
  [ -x "build/release/bin/$program" ] || { echo "v4l2_vm: build/release/bin/$program is not built" >&2; exit 2; }
done
hil/v4l2/setup_vm.sh || exit 1
# Copies, so that a build meanwhile does not change what is under test.
mkdir -p build/v4l2_vm/bin
cp --remove-destination build/release/bin/polhode build/release/bin/filecam_feed build/v4l2_vm/bin/ || exit 1
rm -rf build/v4l2_vm/sequences
.venv/bin/python -m polhode_ground.v4l2.sequences build/v4l2_vm/sequences || exit 1

jobs=("$@")
[ "${#jobs[@]}" -gt 0 ] || for file in hil/v4l2/jobs/*.sh; do jobs+=("$(basename "$file" .sh)"); done
failed=0
for job in "${jobs[@]}"; do
  [ -f "hil/v4l2/jobs/$job.sh" ] || { echo "v4l2_vm: no job '$job' in hil/v4l2/jobs" >&2; exit 2; }
  [ "$job" != package ] || hil/v4l2/package_root.sh || { failed=1; continue; }
  out=$RESULTS/$job
  rm -rf "$out"
  mkdir -p "$out"
  cp -r build/v4l2_vm/sequences "$out/sequences"
  before=$(date +%s)
  hil/v4l2/boot.sh "hil/v4l2/jobs/$job.sh" "$out" "$TIMEOUT_S"
  status=$?
  if [ $status -eq 0 ]; then
    .venv/bin/python -m polhode_ground.v4l2.judge "$job" "$out" >> "$out/told.txt" || status=1
  fi
  printf '%-14s %-6s %4d s\n' "$job" "$([ $status -eq 0 ] && echo passed || echo FAILED)" $(($(date +%s) - before))
  [ -f "$out/told.txt" ] && sed 's/^/    /' "$out/told.txt"
  if [ $status -ne 0 ]; then
    failed=1
    tail -n 30 "$out/console.txt" | sed 's/^/    | /'
  fi
done
exit $failed
