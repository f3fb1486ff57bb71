# The live run on the test camera: the host judges its bus stream against a replay of the same sequence.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load_filecam || fail "the test camera does not load"
fetch body
config live 320 240 600
$FEED --sequence $WORK/body &
$POLHODE run --config $WORK/live.toml "${SETTINGS[@]}" --set run.frames_max=24 2> $WORK/live/stderr.txt || fail "the run"
wait
keep live
