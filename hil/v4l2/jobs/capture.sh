# Every format of the test camera, octet for octet; vivid's, as far as they can be judged; the cost of a frame at 1080p.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load_filecam || fail "the test camera does not load"
fetch noise8
fetch noise16
for format in GREY Y16 Y12 Y10; do
  name=filecam_$format
  config "$name" 64 48 100
  [ $format = GREY ] && sequence=noise8 || sequence=noise16
  $FEED --sequence $WORK/$sequence &
  $POLHODE run --config "$WORK/$name.toml" --set "device.pixel_format=\"$format\"" --set run.frames_max=8 \
    --set "recording.folder=\"$WORK/$name/recording\"" --set recording.complete=true 2> "$WORK/$name/stderr.txt" || fail "$format"
  wait
  keep "$name"
done
$POLHODE camera probe /dev/video0 --width 1920 --height 1080 | tee /mnt/probe.txt | tail -n 1
rmmod filecam

load vivid || fail "vivid does not load"
$POLHODE camera list > /mnt/list.txt
for format in GREY Y16 Y12 Y10 YUYV RGB24; do
  name=vivid_$format
  config "$name" 320 180 300
  $POLHODE run --config "$WORK/$name.toml" "${SETTINGS[@]}" --set "device.pixel_format=\"$format\"" --set device.rate_hz=15.0 --set run.frames_max=4 \
    --set "recording.folder=\"$WORK/$name/recording\"" --set recording.complete=true 2> "$WORK/$name/stderr.txt" || fail "vivid $format"
  keep "$name"
done
v4l2-ctl -d /dev/video0 -c test_pattern=6,osd_text_mode=2 || true # all black, no text: a dark frame, so that the estimator stays out of it
name=full_hd
config $name 1920 1080 2000
$POLHODE run --config "$WORK/$name.toml" --set device.pixel_format='"GREY"' --set device.rate_hz=30.0 --set run.frames_max=60 \
  --set device.backlog_frames_max=1 2> "$WORK/$name/stderr.txt" || fail "1080p"
keep $name
