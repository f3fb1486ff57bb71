# The installed unit under a systemd that is the first process of a system of its own: the host's files with a layer of memory over them,
# and no units but what the service needs. Started, killed at frame 18, started anew by systemd, stopped.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
load_filecam || fail "the test camera does not load"
load overlay || fail "no overlays"
fetch body

SYSTEM=/run/system
mkdir -p $SYSTEM
mount -t tmpfs tmpfs $SYSTEM
mkdir $SYSTEM/{over,work,merged}
mount -t overlay overlay -o lowerdir=/,upperdir=$SYSTEM/over,workdir=$SYSTEM/work $SYSTEM/merged || fail "no overlay"
ROOT=$SYSTEM/merged

# What cmake --install puts there, a user, a configuration; of systemd's own units only those that others need.
install -D -m 755 $POLHODE $ROOT/usr/bin/polhode
install -D -m 644 "$REPOSITORY/platform/systemd/polhode.service" $ROOT/lib/systemd/system/polhode.service
echo 'polhode:x:990:990::/:/usr/sbin/nologin' >> $ROOT/etc/passwd
echo 'polhode:x:990:' >> $ROOT/etc/group
grep -q ^video: $ROOT/etc/group || echo 'video:x:44:' >> $ROOT/etc/group
chgrp video /dev/video0 && chmod 660 /dev/video0
rm -rf $ROOT/{lib,etc}/systemd/system/{sysinit,multi-user,timers,sockets,local-fs,graphical,default}.target.wants
rm -rf $ROOT/var/log/journal $ROOT/etc/fstab
: > $ROOT/etc/machine-id
config unit 320 240 600
mkdir -p $ROOT/etc/polhode
{ sed -e 's#^folder = .*#folder = "/var/lib/polhode"#' $WORK/unit.toml
  printf 'checkpoint = "/var/lib/polhode/checkpoint"\ncheckpoint_frames = 1\npriority = 10\ncore = 0\n'
  printf '[features]\ncount_max = 250\nworking_pixels_max = 40000\n'
} > $ROOT/etc/polhode/live.toml
cat > $ROOT/lib/systemd/system/flight.target <<UNIT
[Unit]
Requires=polhode.service
After=polhode.service
UNIT
cat > /run/first_process <<'FIRST'
mount --make-rprivate /
mount -t proc proc /run/system/merged/proc
mount -t sysfs sysfs /run/system/merged/sys
mount -t cgroup2 cgroup2 /run/system/merged/sys/fs/cgroup
mount --rbind /dev /run/system/merged/dev
mount -t tmpfs tmpfs /run/system/merged/run
mount -t tmpfs tmpfs /run/system/merged/tmp
mkdir -p /run/system/merged/old
cd /run/system/merged && pivot_root . old && umount -l /old
exec env -i container=virtual-machine PATH=/usr/sbin:/usr/bin /lib/systemd/systemd --system --unit=flight.target --log-target=console --show-status=0
FIRST
unshare --pid --fork --mount --cgroup bash /run/first_process > /mnt/systemd.txt 2>&1 &
until FIRST=$(pgrep -f '^/lib/systemd/systemd --system'); do sleep 0.2; done
inside() { nsenter --target "$FIRST" --mount --pid --cgroup --root --wd "$@"; }
state() { inside systemctl show polhode --property="$1" --value; }
# Asked once a second: a program that is started makes virtual time pass.
until_state() { for _ in $(seq 300); do [ "$(state ActiveState 2> /dev/null)" = "$1" ] && return 0; sleep 1; done; inside systemctl status polhode; fail "not $1"; }

until_state active
tell "started by systemd $(inside systemctl --version | sed -n '1s/systemd \([^ ]*\).*/\1/p'), ready after $(( ($(state ActiveEnterTimestampMonotonic) - $(state ExecMainStartTimestampMonotonic)) / 1000 )) ms"
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
