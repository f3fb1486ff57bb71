# Exposure and gain follow the light: a target that is sixteen times too dark at first, then in four times as much light.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load_filecam || fail "the test camera does not load"
fetch small
config exposure 160 120 300
sed -i 's/exposure_control = false/exposure_control = true/' $WORK/exposure.toml
echo "28 light 0.25" > $WORK/script
$FEED --sequence $WORK/small --script $WORK/script --light 0.0625 > $WORK/exposure/sensor.txt &
$POLHODE run --config $WORK/exposure.toml "${SETTINGS[@]}" --set device.rate_hz=20.0 --set run.frames_max=48 2> $WORK/exposure/stderr.txt || fail "the run"
wait
keep exposure
