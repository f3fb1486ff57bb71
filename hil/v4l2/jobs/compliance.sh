# The test camera itself: V4L2's own compliance test, streaming included.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load_filecam || fail "the test camera does not load"
# 40 frames of 640x480 wait at the camera's light side for whoever streams.
perl -e '$| = 1; open(my $in, ">", "/dev/filecam_in") or die; for (1 .. 40) {
  syswrite($in, pack("LLQLL", 0, 0, 0, 0, 307200) . (chr($_) x 307200)); }' &
feeder=$!
v4l2-compliance -d /dev/video0 -s 5 > /mnt/compliance.txt 2>&1
kill $feeder 2>/dev/null
last=$(tail -n 1 /mnt/compliance.txt)
tell "v4l2-compliance: $last"
case $last in *"Failed: 0,"*) exit 0 ;; *) exit 1 ;; esac
