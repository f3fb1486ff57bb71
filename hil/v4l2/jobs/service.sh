# The installed unit under a systemd that is the first process of a system of its own, over the host's files.
# Started, killed at frame 18, started anew by systemd, stopped.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
. "$REPOSITORY/hil/v4l2/jobs/system.inc"
load_filecam || fail "the test camera does not load"
fetch body
prepare_system /

# What cmake --install puts there, and a user.
install -D -m 755 $POLHODE $ROOT/usr/bin/polhode
install -D -m 644 "$REPOSITORY/platform/systemd/polhode.service" $ROOT/lib/systemd/system/polhode.service
echo 'polhode:x:990:990::/:/usr/sbin/nologin' >> $ROOT/etc/passwd
echo 'polhode:x:990:' >> $ROOT/etc/group
grep -q ^video: $ROOT/etc/group || echo 'video:x:44:' >> $ROOT/etc/group
camera_for_service unit 'checkpoint = "/var/lib/polhode/checkpoint"\ncheckpoint_frames = 1\npriority = 10\ncore = 0\n'
boot_system

until_state active
tell "started by systemd $(inside systemctl --version | sed -n '1s/systemd \([^ ]*\).*/\1/p'), ready after $(ready_after_ms) ms"
pid=$(pgrep -x polhode)
grep -E '^(Uid|NoNewPrivs|Seccomp|CapEff|Threads|VmLck)' /proc/$pid/status
tell "as $(ps -o user= -p $pid), scheduling class $(ps -o cls=,rtprio= -p $pid), locked $(sed -n 's/^VmLck:[[:space:]]*//p' /proc/$pid/status), capabilities $(sed -n 's/^CapEff:[[:space:]]*//p' /proc/$pid/status)"
echo $pid > $WORK/pid
echo "18 kill $WORK/pid" > $WORK/script
$FEED --sequence $WORK/body --script $WORK/script &
until [ "$(state NRestarts)" = 1 ]; do sleep 0.5; done
until_state active
wait %2
sleep 20
restarts=$(state NRestarts)
inside systemctl stop polhode
tell "killed at frame 18: started anew by systemd $restarts time; stopped: $(state Result), status $(state ExecMainStatus)"
cp $ROOT/var/lib/polhode/run.json /mnt/ || fail "no run.json"
stat -c '%U %a %n' $ROOT/var/lib/polhode $ROOT/var/lib/polhode/*
[ "$(state Result)" = success ] || fail "$(state Result)"
