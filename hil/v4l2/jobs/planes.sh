# Devices whose frames lie in several planes, and one that gives interlaced fields: the kernel's own test device.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load vivid multiplanar=2 num_inputs=2 input_types=0x04 || fail "vivid does not load"
$POLHODE camera probe /dev/video0 --width 320 --height 180 > /mnt/probe.txt || fail "the probe"
for format in GREY NV12M NV12 UYVY YUV420M NV16M; do
  name=planes_$format
  config "$name" 320 180 300
  $POLHODE run --config "$WORK/$name.toml" "${SETTINGS[@]}" --set "device.pixel_format=\"$format\"" --set device.rate_hz=15.0 --set run.frames_max=4 \
    --set "recording.folder=\"$WORK/$name/recording\"" --set recording.complete=true 2> "$WORK/$name/stderr.txt" || fail "vivid $format: $(tail -n 1 "$WORK/$name/stderr.txt")"
  keep "$name"
done
# A television input gives fields.
v4l2-ctl -d /dev/video0 -i 1 > /dev/null
config interlaced 720 576 800
$POLHODE run --config "$WORK/interlaced.toml" --set run.frames_max=4 2> /mnt/interlaced.txt
[ $? = 2 ] && grep -q "gives interlaced" /mnt/interlaced.txt || fail "interlaced: $(tail -n 1 /mnt/interlaced.txt)"
