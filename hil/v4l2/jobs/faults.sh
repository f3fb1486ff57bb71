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
$POLHODE run --config $WORK/faults.toml "${SETTINGS[@]}" --set run.frames_max=24 2> /mnt/faults_stderr.txt &
run=$!
$FEED --sequence $WORK/body --script $WORK/script || kill $run # a feeder that waits in vain ends the run, too
wait $run || fail "the run with faults"
wait
keep faults

# Held by another program at first; killed at frame 12, started anew by this loop as by a service manager.
config killed 320 240 600
v4l2-ctl -d /dev/video0 --set-fmt-video=width=320,height=240,pixelformat=GREY --stream-mmap --stream-count=1000 > /dev/null 2>&1 &
holder=$!
# Asked without streaming: a stream that is begun before the holder's would wait for ever.
until v4l2-ctl -d /dev/video0 --set-fmt-video=width=320,height=240,pixelformat=GREY 2>&1 | grep -q busy; do sleep 0.1; done
echo "12 kill $WORK/pid" > $WORK/script
said=$WORK/killed/stderr1.txt
(until_said "camera: busy" $said; kill $holder; until_said "camera: streaming" $said; $FEED --sequence $WORK/body --script $WORK/script) &
for start in 1 2; do
  $POLHODE run --config $WORK/killed.toml "${SETTINGS[@]}" --set "run.checkpoint=\"$WORK/killed/checkpoint\"" \
    --set run.checkpoint_frames=5 --set "run.folder=\"$WORK/killed/$start\"" --set run.frames_max=$((start == 1 ? 24 : 10)) \
    2> "$WORK/killed/stderr$start.txt" &
  echo $! > $WORK/pid
  wait $(cat $WORK/pid)
  echo "start $start ended with $?"
done
wait
keep killed

# Unplugged for 0 to 0.5 s. Somebody holds the first node all the while, so that its number stays taken and the device comes back
# under another.
config cycles 64 48 100
cat > $WORK/script <<SCRIPT
0 disconnect 0.3
1 disconnect 0.3
1 disconnect 0.5
2 disconnect 0
3 disconnect 0.3
4 disconnect 0.3
5 disconnect 0.3
6 disconnect 0.1
6 disconnect 0
7 disconnect 0.3
SCRIPT
$POLHODE run --config $WORK/cycles.toml --set run.frames_max=8 2> $WORK/cycles/stderr.txt &
run=$!
until_said "camera: streaming" $WORK/cycles/stderr.txt
exec 9< /dev/video0
$FEED --sequence $WORK/noise8 --script $WORK/script || kill $run &
# Nothing but the shell itself: programs from the share would make virtual time jump.
while kill -0 $run 2> /dev/null; do
  while read -r name value _; do
    case $name in VmRSS:) resident=$value ;; VmSize:) mapped=$value ;; esac
  done 2> /dev/null < /proc/$run/status
  descriptors=(/proc/$run/fd/*)
  echo "$resident $mapped ${#descriptors[@]}"
  sleep 0.2
done > $WORK/cycles/growth.txt
wait $run
wait
exec 9<&-
keep cycles
