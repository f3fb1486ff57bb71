# The packaged unit, once: a bare Debian root into which apt has put polhode and polhode-ground (hil/v4l2/package_root.sh), under its own
# systemd. It reaches READY, sends its packets to a socket of the ground package's client and to a file, and is stopped.
. "$REPOSITORY/hil/v4l2/jobs/common.inc"
. "$REPOSITORY/hil/v4l2/jobs/system.inc"
load_filecam || fail "the test camera does not load"
fetch body
prepare_system "$REPOSITORY/build/v4l2_vm/package_root"
camera_for_service unit 'priority = 10\ncore = 0\n[transport]\nsend = ["unix:/run/polhode/telemetry"]\n'
boot_system

until_state active
tell "ready after $(ready_after_ms) ms, as $(inside stat -c %U "/proc/$(state MainPID)")"
# Until it has heard of both, for ten minutes of the guest at most.
cat > $ROOT/listen.py <<'LISTEN'
import collections, time, polhode_bus
heard, end = collections.Counter(), time.monotonic() + 600
with polhode_bus.open_bus("unix:/run/polhode/telemetry") as bus:
    while time.monotonic() < end and not (heard["housekeeping"] and heard["motion"]):
        for packet in bus.packets(timeout_s=2.0):
            heard[packet.name] += 1
            if heard["housekeeping"] and heard["motion"]:
                break
print(", ".join(f"{count} {name}" for name, count in sorted(heard.items()) if count))
raise SystemExit(not (heard["housekeeping"] and heard["motion"]))
LISTEN
inside runuser -u polhode -- python3 /listen.py > $WORK/heard &
listener=$!
until inside test -S /run/polhode/telemetry; do sleep 1; kill -0 $listener || fail "the client of the ground package ended"; done
$FEED --sequence $WORK/body &
feeder=$!
wait $listener || fail "the ground package has heard only: $(cat $WORK/heard)"
tell "heard by the client of the ground package: $(cat $WORK/heard)"
inside systemctl stop polhode
kill $feeder 2> /dev/null # where frames are left
tell "stopped: $(state Result), status $(state ExecMainStatus)"
cp $ROOT/var/lib/polhode/{run.json,bus.ccsds} /mnt/ || fail "no results"
[ "$(state Result)" = success ] || fail "$(state Result)"
