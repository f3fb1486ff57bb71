"""polhode run on a played sequence: the same bytes as a replay, clean ends, starts from a checkpoint."""

import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import time

import polhode_bus
import pytest
from polhode_ground.testing.replay_files import PROGRAM


def bus(run):
    return (run.folder / "bus.ccsds").read_bytes()


def report(run):
    return json.loads((run.folder / "run.json").read_text())


# verifies: LIV-01
def test_gives_the_bytes_of_a_replay(live, played, replayed):
    run = live(played.path)
    assert run.finish().status == 0
    assert bus(run) == replayed(played.path)
    assert report(run)["frames_accepted"] == 12


def test_at_its_own_pace_gives_the_bytes_of_a_replay(live, played, replayed):
    """Slowed down tenfold, so that no frame is late on a loaded machine either; those that are would be counted."""
    run = live(played.path, device__sequence_speed=0.25, device__backlog_frames_max=32)
    before = time.monotonic()
    assert run.finish().status == 0
    assert time.monotonic() - before >= 1.1 / 0.25
    assert report(run)["camera"]["frames_late"] == 0
    assert bus(run) == replayed(played.path)


# verifies: LIV-10
def test_unreadable_frames_are_answered_and_counted(live, played, replayed):
    for name in ("1300000000", "1900000000"):
        (played.data / f"{name}.png").write_bytes(b"no picture")
    run = live(played.path)
    assert run.finish().status == 0
    assert report(run)["camera"]["frames_damaged"] == 2
    assert bus(run) == replayed(played.path)


def test_a_stop_request_ends_it_in_order(live, played, until, tmp_path):
    run = live(played.path, device__sequence_passes=100000, run__checkpoint=tmp_path / "checkpoint")
    until(lambda: (run.folder / "bus.ccsds").exists() and len(bus(run)) > 1000)
    before = time.monotonic()
    run.process.send_signal(signal.SIGTERM)
    ended = run.finish()
    assert ended.status == 0
    assert time.monotonic() - before < 10  # 100 ms of waiting, a step, 1 MB to the disk; on a loaded machine
    assert "stopped" in ended.err
    assert len(bus(run)) % 178 == 0 or len(bus(run)) > 0
    assert report(run)["checkpoints"]["failed"] == 0
    assert (tmp_path / "checkpoint").exists()


def test_continues_where_a_checkpoint_says(live, played, tmp_path):
    checkpoint = tmp_path / "checkpoint"
    first = live(played.path, name="first", run__checkpoint=checkpoint)
    assert "cold" in first.finish().err
    second = live(played.path, name="second", run__checkpoint=checkpoint)
    assert "start warm: from frame 12" in second.finish().err
    # The sequence begins anew, its time does not: those frames are answered, not used.
    assert report(second)["start"].startswith("warm")


def test_a_start_without_a_camera_leaves_the_checkpoint_as_it_is(live, played, tmp_path):
    checkpoint = tmp_path / "checkpoint"
    assert live(played.path, name="first", run__checkpoint=checkpoint).finish().status == 0
    before = checkpoint.read_bytes()
    camera = dict.fromkeys(("camera__width_px", "camera__height_px"), 160) | {"camera__height_px": 120}
    lens = {"camera__fu_px": 200.0, "camera__fv_px": 200.0, "camera__cu_px": 79.5, "camera__cv_px": 59.5}
    live("/dev/video987", name="second", run__start_s_max=1, run__checkpoint=checkpoint, **camera, **lens).finish()
    assert checkpoint.read_bytes() == before


@pytest.mark.parametrize("spoil, reason", [
    (lambda octets: octets[:-1], "torn"),
    (lambda octets: octets[:60], "too short"),
    (lambda octets: octets[:1000] + b"\x00" + octets[1001:] if octets[1000] else octets[:1000] + b"\x01" + octets[1001:], "torn"),
    (lambda octets: b"", "too short"),
])
def test_a_bad_checkpoint_is_refused_and_the_run_starts_cold(live, played, replayed, tmp_path, spoil, reason):
    checkpoint = tmp_path / "checkpoint"
    assert live(played.path, name="first", run__checkpoint=checkpoint).finish().status == 0
    checkpoint.write_bytes(spoil(checkpoint.read_bytes()))
    run = live(played.path, name="second", run__checkpoint=checkpoint)
    ended = run.finish()
    assert ended.status == 0
    assert "cold" in ended.err and reason in ended.err
    assert bus(run) == replayed(played.path)


def test_an_old_checkpoint_and_one_of_another_configuration_are_refused(live, played, tmp_path):
    checkpoint = tmp_path / "checkpoint"
    assert live(played.path, name="first", run__checkpoint=checkpoint).finish().status == 0
    other = live(played.path, name="other", settings=["seed=2"], run__checkpoint=checkpoint)
    assert "of another configuration" in other.finish().err
    assert live(played.path, name="again", run__checkpoint=checkpoint).finish().status == 0
    time.sleep(2.1)
    old = live(played.path, name="old", run__checkpoint=checkpoint, run__checkpoint_age_s_max=1)
    assert "s old" in old.finish().err


def test_tells_the_service_manager(live, played, tmp_path):
    address = tmp_path / "notify"
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    listener.bind(str(address))
    listener.setblocking(False)
    run = live(played.path, env={"NOTIFY_SOCKET": str(address), "WATCHDOG_USEC": "60000000"})
    assert run.finish().status == 0
    told = []
    while True:
        try:
            told.append(listener.recv(4096).decode())
        except BlockingIOError:
            break
    assert told[0].startswith("READY=1")
    assert told[-1].startswith("STOPPING=1")
    assert "WATCHDOG=1" in told


# verifies: LIV-06
def test_no_progress_no_watchdog(live, played, tmp_path, until):
    """Frames that are not due are no progress, however often the loop turns."""
    address = tmp_path / "notify"
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    listener.bind(str(address))
    listener.settimeout(60)
    run = live(played.path, device__sequence_speed=1.0, device__sequence_start_ns=time.monotonic_ns() + 3600 * 10**9,
               env={"NOTIFY_SOCKET": str(address), "WATCHDOG_USEC": "4000"})
    assert listener.recv(4096).decode().startswith("READY=1")
    listener.settimeout(2)
    with pytest.raises(TimeoutError):
        while "WATCHDOG" not in listener.recv(4096).decode():
            pass
    run.process.send_signal(signal.SIGTERM)
    assert run.finish().status == 0


@pytest.mark.parametrize("options, told", [
    ({"device__source": ""}, "device.source"),
    ({"device__source": "/dev/null", "camera__width_px": 64}, "camera.height_px"),
    ({"device__buffers": 1}, "device.buffers = 1: allowed"),
    ({"run__nonsense": 1}, "run.nonsense: unknown key"),
])
def test_an_unusable_configuration_is_refused_before_anything_starts(live, played, options, told):
    run = live(played.path, **options)
    ended = run.finish()
    assert ended.status == 2
    assert told in ended.err
    assert not run.folder.exists()


CAMERA = {"camera__width_px": 64, "camera__height_px": 48, "camera__fu_px": 100.0, "camera__fv_px": 100.0,
          "camera__cu_px": 31.5, "camera__cv_px": 23.5}


def test_what_is_no_video_device_is_refused(live):
    ended = live("/dev/null", **CAMERA).finish()
    assert ended.status == 2
    assert "device.source: unsuitable: /dev/null: not a V4L2 device" in ended.err


@pytest.mark.parametrize("key", ["run.folder", "run.checkpoint", "recording.folder"])
def test_what_cannot_be_written_is_found_before_the_run_starts(live, played, key):
    run = live(played.path, settings=[f'{key}="/proc/polhode/here"'])
    ended = run.finish()
    assert ended.status == 2
    assert f"{key}: /proc/polhode/here: " in ended.err.splitlines()[-1]
    assert "warmed up" not in ended.err


def test_files_of_a_run_follow_no_link_and_are_its_own(live, played, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine")
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "bus.ccsds").symlink_to(precious)
    ended = live(played.path).finish()
    assert ended.status == 2 and f"{folder}/bus.ccsds: is a symbolic link" in ended.err
    (folder / "bus.ccsds").unlink()
    (folder / "bus.ccsds").write_bytes(b"")
    (folder / "bus.ccsds").chmod(0o666)
    ended = live(played.path).finish()
    assert ended.status == 2 and f"{folder}/bus.ccsds: is open to others: mode 0666" in ended.err
    (folder / "bus.ccsds").unlink()
    for name in ("run.json", "run.json.new"):
        (folder / name).symlink_to(precious)
    run = live(played.path)
    assert run.finish().status == 0 and report(run) and not (folder / "run.json").is_symlink()
    assert precious.read_text() == "mine" and sorted(file.name for file in folder.iterdir()) == ["bus.ccsds", "run.json", "run.json.new"]


def test_a_camera_that_does_not_come_ends_the_run(live):
    ended = live("/dev/video987", run__start_s_max=1, **CAMERA).finish()
    assert ended.status == 1
    assert "no camera within 1 s" in ended.err


def test_is_warmed_up_by_a_body_whose_map_is_begun(live):
    camera = {"camera__width_px": 640, "camera__height_px": 480, "camera__fu_px": 960.0, "camera__fv_px": 960.0,
              "camera__cu_px": 320.0, "camera__cv_px": 240.0}
    said = live("/dev/video987", run__start_s_max=1, **camera).finish().err.splitlines()[0]
    assert said.startswith("warmed up: ") and int(said.split()[2]) >= 3


def test_commands_for_people(tmp_path):
    assert subprocess.run([PROGRAM, "camera", "list"], capture_output=True).returncode == 0
    probe = subprocess.run([PROGRAM, "camera", "probe", "/dev/null"], capture_output=True, text=True)
    assert probe.returncode == 2 and "not a V4L2 device" in probe.stderr
    empty = subprocess.run([PROGRAM, "recording", "list", tmp_path], capture_output=True, text=True)
    assert empty.returncode == 2 and "holds no recording" in empty.stderr
    assert os.path.exists(PROGRAM)


def test_the_frames_thread_alone_is_bound_to_its_core(live, played, until):
    run = live(played.path, device__sequence_passes=100000, run__core=0, jobs__delay_frames=1)
    until(lambda: (run.folder / "bus.ccsds").exists() and len(bus(run)) > 1000)
    tasks = pathlib.Path(f"/proc/{run.process.pid}/task")
    cores = {task.name: next(line.split()[1] for line in (task / "status").read_text().splitlines() if line.startswith("Cpus_allowed_list"))
             for task in tasks.iterdir()}
    run.process.send_signal(signal.SIGTERM)
    assert run.finish().status == 0
    assert cores[str(run.process.pid)] == "0"
    if os.cpu_count() > 1:
        assert "0" not in [core for task, core in cores.items() if task != str(run.process.pid)]


def test_a_core_that_is_not_there_is_said(live, played):
    ended = live(played.path, run__core=1023).finish()
    assert ended.status == 0
    assert "not bound to core 1023: Invalid argument" in ended.err


def test_commands_are_answered_to_whoever_waits(live, played, until, tmp_path):
    ring = f"/polhode_answers_{os.getpid()}"
    commands = f"unix:{tmp_path}/commands"

    def send(*words):
        return subprocess.run([PROGRAM, "bus", "send", commands, *words, "--wait", f"shm:{ring}", "--timeout", "20"], capture_output=True, text=True, timeout=60)

    run = live(played.path, device__sequence_passes=100000, device__sequence_speed=1.0,
               settings=[f'transport.send=["shm:{ring}"]', f'transport.receive="{commands}"'])
    try:
        until(lambda: (tmp_path / "commands").exists() and pathlib.Path(f"/dev/shm{ring}").exists())
        done = send("noop", "+", "table_load", "features.count_max=500", "+", "table_activate")
        assert done.returncode == 0, done.stderr
        assert re.findall(r"frame \d+: (.*)", done.stdout)[0].startswith("NOOP, version") and done.stdout.count("accepted") == 2
        done = send("table_discard", "+", "noop")
        assert done.returncode == 1 and "refused: no table loaded" in done.stdout and "1 of 2 commands were refused" in done.stderr
        done = send("table_load", "features.count_max=5")
        assert done.returncode == 2 and done.stdout == "" and "features.count_max" in done.stderr and "50 .. " in done.stderr
        again = ("hold", "+", "resume", "--sequence", "70")
        first, second = send(*again), send(*again)
        assert first.returncode == second.returncode == 0 and first.stdout.count("accepted") == 2
        assert re.findall(r"frame \d+: (.*)", second.stdout) == ["command 3 hold of count 70 was carried out before",
                                                                 "command 4 resume of count 71 was carried out before"]
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as deaf:
            deaf.bind(str(tmp_path / "deaf"))
            waiting = subprocess.Popen([PROGRAM, "bus", "send", f"unix:{tmp_path}/deaf", "noop", "--sequence", "90", "--wait", f"shm:{ring}", "--timeout", "8"],
                                       stdout=subprocess.PIPE, text=True)
            deaf.recv(2000)  # it listens by now
            assert send("noop", "--sequence", "91").returncode == 0
            told, _ = waiting.communicate(timeout=60)
            assert waiting.returncode == 1 and told == ""  # the other's answer is not its own
        run.process.send_signal(signal.SIGTERM)
        assert run.finish().status == 0
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as deaf:
            deaf.bind(str(tmp_path / "commands"))
            done = subprocess.run([PROGRAM, "bus", "send", commands, "noop", "--wait", f"shm:{ring}", "--timeout", "0.5"], capture_output=True, text=True, timeout=60)
        assert done.returncode == 1 and done.stderr.endswith(f"shm:{ring}: 0 of 1 commands were answered within 0.5 s\n")
    finally:
        pathlib.Path(f"/dev/shm{ring}").unlink(missing_ok=True)


def test_old_answers_in_a_file_are_no_answers_and_octets_have_their_own_count(live, played, until, tmp_path):
    commands, link = f"unix:{tmp_path}/commands", f"file:{tmp_path}/flight.ccsds"

    def send(*words, to=commands, timeout="20"):
        return subprocess.run([PROGRAM, "bus", "send", to, *words, "--wait", link, "--timeout", timeout], capture_output=True, text=True, timeout=60)

    run = live(played.path, device__sequence_passes=100000, device__sequence_speed=1.0,
               settings=[f'transport.send=["{link}"]', f'transport.receive="{commands}"'])
    until(lambda: (tmp_path / "commands").exists() and (tmp_path / "flight.ccsds").exists())
    assert send("noop").returncode == 0
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as deaf:
        deaf.bind(str(tmp_path / "deaf"))
        done = send("noop", to=f"unix:{tmp_path}/deaf", timeout="3")
    assert done.returncode == 1 and done.stdout == "" and "0 of 1 commands were answered" in done.stderr  # that of the first is in the file
    hold = polhode_bus.make_command("hold", sequence=812)
    done = send("hex", hold.hex(), "+", "resume", "--sequence", "70")
    assert done.returncode == 0 and done.stdout.count("accepted") == 2, done.stderr
    spoilt = hold[:-1] + bytes([hold[-1] ^ 1])
    done = send("hex", spoilt.hex(), "--sequence", "70")
    assert done.returncode == 1 and "1 of 1 commands were refused" in done.stderr
    run.process.send_signal(signal.SIGTERM)
    assert run.finish().status == 0
