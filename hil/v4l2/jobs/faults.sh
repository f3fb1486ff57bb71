# Faults of the device in the middle of a run; then another program on it, SIGKILL and a start from the checkpoint; then ten times
# unplugged.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load_filecam || fail "the test camera does not load"
fetch body
fetch noise8

config faults 320 240 600
cat > $WORK/script <<SCRIPT
6 damage
8 skip 3
9 fatal
11 disconnect 1.5
13 pause 3
SCRIPT
$FEED --sequence $WORK/body --script $WORK/script &
timeout 120 $POLHODE run --config $WORK/faults.toml "${SETTINGS[@]}" --set run.frames_max=24 2> /mnt/faults_stderr.txt || fail "the run with faults"
kill %1 2>/dev/null
wait
keep faults

# Held by another program at first; killed at frame 12, started anew by this loop as by a service manager.
config killed 320 240 600
v4l2-ctl -d /dev/video0 --set-fmt-video=width=320,height=240,pixelformat=GREY --stream-mmap --stream-count=1000 > /dev/null 2>&1 &
holder=$!
until [ "$(v4l2-ctl -d /dev/video0 --stream-mmap --stream-count=1 2>&1 | grep -c busy)" -gt 0 ]; do sleep 0.1; done
(sleep 2; kill $holder) &
echo "12 kill $WORK/pid" > $WORK/script
for start in 1 2; do
  $POLHODE run --config $WORK/killed.toml "${SETTINGS[@]}" --set "run.checkpoint=\"$WORK/killed/checkpoint\"" \
    --set run.checkpoint_frames=5 --set "run.folder=\"$WORK/killed/$start\"" --set run.frames_max=$((start == 1 ? 24 : 10)) \
    2> "$WORK/killed/stderr$start.txt" &
  echo $! > $WORK/pid
  [ $start -eq 2 ] || { sleep 4; $FEED --sequence $WORK/body --script $WORK/script & }
  wait $(cat $WORK/pid)
  echo "start $start ended with $?"
done
wait
keep killed

config cycles 64 48 100
for frame in 0 1 2 3 4 5 6 7; do echo "$frame disconnect 0.3"; done > $WORK/script
echo "1 disconnect 0.5" >> $WORK/script
echo "6 disconnect 0.1" >> $WORK/script
timeout 120 $POLHODE run --config $WORK/cycles.toml --set run.frames_max=8 2> $WORK/cycles/stderr.txt &
sleep 1
run=$(pgrep -x polhode)
$FEED --sequence $WORK/noise8 --script $WORK/script &
while kill -0 $run 2>/dev/null; do
  echo "$(grep VmRSS /proc/$run/status 2>/dev/null | tr -dc 0-9) $(ls /proc/$run/fd 2>/dev/null | wc -l) $(grep -c video /proc/$run/maps 2>/dev/null)" >> $WORK/cycles/growth.txt
  sleep 0.2
done
wait
keep cycles
