"""polhode run takes commands of those who hold the key, once, and says who else may give them."""

import json
import pathlib
import socket
import sys
import time

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "platform/transport/client/python"))

import polhode_bus  # noqa: E402

UDP = "udp:40126"


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
    until(lambda: (run.folder / "bus.ccsds").exists() and (run.folder / "bus.ccsds").stat().st_size > 0)


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
            sender.sendto(datagram, ("127.0.0.1", 40126))
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


# verifies: CMD-06
def test_without_a_key_udp_takes_commands_only_where_the_configuration_says_so(live, played, tmp_path, until):
    refused = live(played.path, name="refused", transport__receive=UDP).finish()
    assert refused.status == 2 and "commands.unauthenticated" in refused.err and len(refused.err.splitlines()) == 1
    run = live(played.path, name="open", transport__receive=UDP, commands__unauthenticated=True, device__sequence_speed=1.0,
               settings=[f'transport.send=["file:{tmp_path}/open.ccsds"]'])
    wait_until_it_takes(run, until)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(polhode_bus.make_command("noop"), ("127.0.0.1", 40126))
    ended = run.finish()
    assert ended.status == 0 and "commands are unauthenticated" in ended.err
    counts = json.loads((run.folder / "run.json").read_text())["transport"]
    assert not counts["commands_signed"] and counts["commands_passed"] == 1
    assert packets(tmp_path / "open.ccsds", "command_link")[0].unauthenticated


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
                sender.sendto(forged, ("127.0.0.1", 40126))
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
