"""polhode run takes commands of those who hold the key, once, and says who else may give them."""

import json
import os
import pathlib
import socket
import subprocess
import time

import polhode_bus
import pytest
from polhode_ground.testing.replay_files import PROGRAM


def free_port() -> int:
    """Other tests run beside this one: a port of ours alone would still be one that the system gives to somebody."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


PORT = free_port()
UDP = f"udp:{PORT}"


@pytest.fixture
def key(tmp_path):
    file = tmp_path / "commands.key"
    file.write_text("c4" * 32)
    file.chmod(0o600)
    return file


@pytest.fixture
def signed(live, played, tmp_path, key):
    """A run of some seconds that takes signed commands, and what its bus says."""

    def start(name):
        return live(played.path, name=name, device__sequence_speed=0.5, device__sequence_passes=2, commands__key=key,
                    commands__window=tmp_path / "window", transport__receive=UDP, run__report_s=1,
                    settings=[f'transport.send=["file:{tmp_path}/{name}.ccsds"]'])

    return start


def packets(file, name):
    with polhode_bus.open_bus(f"file:{file}") as bus:
        return [packet for packet in bus.packets(timeout_s=0.0) if packet.name == name]


def wait_until_it_takes(run, until):
    """Its port is bound before the first frame is stepped."""
    def takes() -> bool:
        file = run.folder / "bus.ccsds"
        there = file.exists() and file.stat().st_size > 0
        assert there or run.process.poll() is None, run.process.stderr.read()
        return there

    until(takes)


# verifies: CMD-05
def test_a_captured_command_is_not_taken_again_after_a_restart_either(signed, until, tmp_path, key):
    octets = None
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for name, passed, repeated in (("first", 1, 1), ("second", 0, 2)):
        run = signed(name)
        wait_until_it_takes(run, until)
        # Signed once the first run is there: without kept numbers they begin at the time of its start.
        octets = octets or polhode_bus.sign(polhode_bus.read_key(key), time.time_ns(), polhode_bus.make_command("reset_counters"))
        for datagram in (octets, octets, polhode_bus.make_command("hold"), octets[:-1] + bytes([octets[-1] ^ 1]), b"x"):
            sender.sendto(datagram, ("127.0.0.1", PORT))
        ended = run.finish()
        assert ended.status == 0, ended.err
        counts = json.loads((run.folder / "run.json").read_text())["transport"]
        assert counts["commands_signed"] and counts["commands_received"] == 5
        assert counts["commands_passed"] == passed
        assert counts["commands_refused"] == {"sender": 0, "form": 2, "mac": 1, "number": repeated}
        answered = [event for event in packets(run.folder / "bus.ccsds", "event") if "counters reset" in event.text]
        assert len(answered) == passed
        link = packets(tmp_path / f"{name}.ccsds", "command_link")[-1]
        assert link.key and not link.unauthenticated and link.ports == 1
    sender.close()


def test_a_command_that_is_sent_again_is_answered_and_not_carried_out_again(signed, until, tmp_path, key):
    run = signed("repeated")
    wait_until_it_takes(run, until)
    file = run.folder / "bus.ccsds"
    sender = polhode_bus.CommandSender(UDP, key=key)

    def send_and_wait(octets, event, count):
        sender.send(octets)  # signed anew each time
        until(lambda: sum(polhode_bus.name_of(packet, "id") == event for packet in packets(file, "event")) == count, 15.0)

    hold = polhode_bus.make_command("hold", sequence=900)
    send_and_wait(hold, "command_accepted", 1)
    send_and_wait(polhode_bus.make_command("resume", sequence=901), "command_accepted", 2)
    send_and_wait(hold, "command_repeated", 1)
    send_and_wait(polhode_bus.make_command("reset_counters", sequence=902), "counters_reset", 1)
    sender.close()
    assert run.finish().status == 0
    repeated = next(packet for packet in packets(file, "event") if polhode_bus.name_of(packet, "id") == "command_repeated")
    assert repeated.command_sequence == 900 and polhode_bus.words_of(repeated) == "hold"
    assert not packets(file, "housekeeping")[-1].held


# verifies: CMD-06
def test_without_a_key_udp_takes_commands_only_where_the_configuration_says_so(live, played, tmp_path, until):
    refused = live(played.path, name="refused", transport__receive=UDP).finish()
    assert refused.status == 2 and "commands.unauthenticated" in refused.err and len(refused.err.splitlines()) == 1
    run = live(played.path, name="open", transport__receive=UDP, commands__unauthenticated=True, device__sequence_speed=1.0,
               settings=[f'transport.send=["file:{tmp_path}/open.ccsds"]'])
    wait_until_it_takes(run, until)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(polhode_bus.make_command("noop"), ("127.0.0.1", PORT))
    ended = run.finish()
    assert ended.status == 0 and "commands are unauthenticated" in ended.err
    counts = json.loads((run.folder / "run.json").read_text())["transport"]
    assert not counts["commands_signed"] and counts["commands_passed"] == 1
    assert packets(tmp_path / "open.ccsds", "command_link")[0].unauthenticated


def test_what_the_port_refuses_is_said_with_its_reason(live, played, tmp_path, key, until):
    """By who waits for the answer; the guard itself answers nothing."""
    ring = f"/polhode_refused_{os.getpid()}"
    commands = f"unix:{tmp_path}/commands"
    other = tmp_path / "other.key"
    other.write_text("d5" * 32)
    other.chmod(0o600)

    def send(*words):
        return subprocess.run([PROGRAM, "bus", "send", commands, "noop", *words, "--wait", f"shm:{ring}", "--timeout", "60"],
                              capture_output=True, text=True, timeout=120)

    run = live(played.path, device__sequence_passes=100000, device__sequence_speed=1.0, commands__key=key, commands__window=tmp_path / "window",
               settings=[f'transport.send=["shm:{ring}"]', f'transport.receive="{commands}"'])
    wait_until_it_takes(run, until)
    try:
        for words, reason in (((), "1 not signed (--key)"), (("--key", other), "1 signed by another key"),
                              (("--key", key, "--number", "5"), "1 with a number that was taken or is too old (a clock that is behind)")):
            done = send(*words)
            assert done.returncode == 1, done.stdout
            assert done.stderr == f"polhode: shm:{ring}: 1 of 1 commands were refused at the port: {reason}\n"
        done = send("--key", key)
        assert done.returncode == 0 and "NOOP" in done.stdout, done.stderr
    finally:
        pathlib.Path(f"/dev/shm{ring}").unlink(missing_ok=True)


@pytest.mark.parametrize("commands", ["", '[commands]\nkey = "/nowhere/commands.key"\n'])
def test_a_replay_of_a_flight_needs_neither_its_key_nor_its_port(replayed, program_status, played, tmp_path, commands):
    """It takes no commands from anybody. A run and a check still refuse it."""
    flight = tmp_path / "flight.toml"
    flight.write_text(f'[transport]\nreceive = "{UDP}"\n{commands}')
    assert replayed(played.path, config=flight)
    status, err = program_status("check", "--config", flight)
    assert status == 2 and "commands." in err and len(err.splitlines()) == 1


@pytest.mark.parametrize("keys, named", [({"commands__key": "absent"}, "commands.window"),
                                         ({"commands__key": "absent", "commands__window": "w"}, "commands.key: absent"),
                                         ({"commands__key": 5}, "commands.key"),
                                         ({"commands__unauthenticated": "yes"}, "true or false"),
                                         ({"transport__receive": "file:x"}, "allowed are unix:PATH and udp:")])
def test_bad_settings_are_named(live, played, keys, named):
    ended = live(played.path, **{"transport__receive": UDP, "commands__unauthenticated": "commands__key" not in keys, **keys}).finish()
    assert ended.status == 2 and named in ended.err and len(ended.err.splitlines()) == 1, ended.err


# verifies: CMD-07
def test_a_flood_at_one_port_keeps_neither_frames_nor_the_commands_of_another(live, played, tmp_path, key, until):
    own = f"unix:{tmp_path}/commands"
    run = live(played.path, name="flooded", device__sequence_speed=0.5, device__sequence_passes=2, commands__key=key,
               commands__window=tmp_path / "window", settings=[f'transport.receive=["{UDP}", "{own}"]'])
    wait_until_it_takes(run, until)
    good = polhode_bus.CommandSender(own, key=key)
    sent = 0
    forged = polhode_bus.sign(bytes(32), time.time_ns(), polhode_bus.make_command("hold"))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        until_s = time.monotonic() + 2.0
        while time.monotonic() < until_s:
            for _ in range(200):
                sender.sendto(forged, ("127.0.0.1", PORT))
            if sent < 5:
                good.send(polhode_bus.make_command("noop"))
                sent += 1
    ended = run.finish()
    assert ended.status == 0, ended.err
    counts = json.loads((run.folder / "run.json").read_text())
    assert counts["frames_accepted"] == 23 and counts["frames_dropped_for_job"] == 0  # 12 forth, 11 back
    assert counts["transport"]["commands_passed"] == 5
    assert counts["transport"]["commands_refused"]["mac"] >= 64 * 8  # 64 a step; 2 s are 10 steps
    assert sum(event.id == 40 for event in packets(run.folder / "bus.ccsds", "event")) == 5
