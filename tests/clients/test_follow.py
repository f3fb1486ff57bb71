"""`polhode bus follow` and the Python client on all transports, and commands sent to a socket."""

import json
import os
import subprocess
import time
import tomllib

import pytest
from flights import PROGRAM, REPOSITORY, split


@pytest.fixture
def follow(tmp_path):
    """Starts a reader whose output goes into tmp_path / "followed": a pipe that nobody empties would hold it up."""
    running = []

    def start(address, *arguments):
        with open(tmp_path / "followed", "w") as out:
            process = subprocess.Popen([PROGRAM, "bus", "follow", address, "--json", "--timeout", "10", *arguments],
                                       stdout=out, stderr=subprocess.PIPE, text=True)
        running.append(process)
        return process

    yield start
    for process in running:
        process.kill()


def wait_for(path, seconds=20.0):
    until = time.monotonic() + seconds
    while not os.path.exists(path):
        assert time.monotonic() < until
        time.sleep(0.01)


def send(path, octets):
    import socket

    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.settimeout(20.0)
        sender.sendto(octets, path)


def test_follow_prints_what_comes_and_tells_of_damage(follow, flight, damaged, tmp_path):
    path = str(tmp_path / "telemetry")
    process = follow(f"unix:{path}", "--count", str(len(damaged.packets) - 1))
    wait_for(path)
    assert os.stat(path).st_mode & 0o777 == 0o600
    for octets in damaged.packets:
        send(path, octets)
        time.sleep(0.002)
    _, err = process.communicate(timeout=60)
    lines = [json.loads(line) for line in (tmp_path / "followed").read_text().splitlines()]
    assert [line["packet"] for line in lines if line["packet"] == "motion"] == ["motion"] * (len(flight.rows) - 2)
    assert "310 octets were no packet" in err and "2 missing by their counts" in err
    assert not os.path.exists(path)


IDLE = b"\x07\xff\xc0\x00\x00\x0d" + b"\x55" * 14  # a CCSDS idle packet of 20 octets


def datagrams(packets, kind):
    """As gateways send them: several packets in one, idle ones before, between or behind."""
    if kind == "three in each":
        return [b"".join(packets[at:at + 3]) for at in range(0, len(packets), 3)]
    return [IDLE + octets + IDLE + IDLE for octets in packets]


@pytest.mark.parametrize("kind", ["three in each", "with idle packets"])
def test_all_readers_cut_the_same_octets_alike(follow, flight, tmp_path, kind):
    from polhode_bus import open_bus

    packets = split(flight.stream)[:60]
    sent = datagrams(packets, kind)
    path = str(tmp_path / "telemetry")
    process = follow(f"unix:{path}", "--count", str(len(packets)))
    wait_for(path)
    for octets in sent:
        send(path, octets)
        time.sleep(0.002)
    _, err = process.communicate(timeout=60)
    followed = (tmp_path / "followed").read_text()
    assert f"{len(packets)} packets, 0 missing by their counts, 0 octets damaged" in err and "no packet" not in err
    file = tmp_path / "archive.ccsds"
    file.write_bytes(b"".join(sent))
    dumped = subprocess.run([PROGRAM, "bus", "dump", file, "--json"], capture_output=True, text=True, timeout=60)
    assert dumped.stdout == followed and f"{len(packets)} packets, 0 missing by their counts, 0 octets damaged" in dumped.stderr
    with open_bus(f"unix:{path}.python") as bus:
        got = []
        for octets in sent:
            send(f"{path}.python", octets)
            while (packet := bus.next_octets(0.001)) is not None:
                got.append(packet)
        assert got == packets and bus.missing == bus.damaged == 0
    with open_bus(f"file:{file}") as bus:
        assert [bus.next_octets(0.01) for _ in packets] == packets and bus.next_octets(0.01) is None and bus.damaged == 0


def test_follow_of_a_file_reads_it_from_its_beginning(flight, tmp_path):
    done = subprocess.run([PROGRAM, "bus", "follow", f"file:{flight.file}", "--json", "--timeout", "0.5"], capture_output=True, text=True, timeout=60)
    assert len(done.stdout.splitlines()) == len(flight.packets)


@pytest.mark.parametrize("address", ["unix", "unix:", "udp:x", "shm:none", "http://x", "shm:/polhode_not_there"])
def test_follow_of_nothing_is_refused(address):
    done = subprocess.run([PROGRAM, "bus", "follow", address], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and done.stderr.startswith("polhode: ") and len(done.stderr.splitlines()) == 1


def test_python_client_reads_datagrams(flight, tmp_path):
    from polhode_bus import open_bus

    path = str(tmp_path / "telemetry")
    with open_bus(f"unix:{path}") as bus:
        for octets in split(flight.stream)[:5]:
            send(path, octets)
            assert bus.next_octets(5.0) == octets
        send(path, b"noise")
        assert bus.next_octets(0.05) is None and bus.damaged == 5


def test_python_client_connects_to_the_sender_and_lets_go_of_a_dead_one(flight, tmp_path):
    import socket

    from polhode_bus import open_bus

    path, name = str(tmp_path / "telemetry"), str(tmp_path / "telemetry.sender")
    packets = split(flight.stream)
    with open_bus(f"unix:{path}") as bus:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
            sender.bind(name)
            sender.setblocking(False)
            sender.sendto(packets[0], path)
            assert bus.next_octets(5.0) == packets[0]
            for octets in packets[1:40]:  # of a stranger the system would hold 10
                sender.sendto(octets, path)
            assert [bus.next_octets(5.0) for _ in range(39)] == packets[1:40]
        assert bus.next_octets(0.3) is None
        send(path, packets[40])
        assert bus.next_octets(5.0) == packets[40]


def test_python_client_waits_beside_a_sender_that_never_reads(flight, tmp_path):
    import socket

    from polhode_bus import open_bus

    path = str(tmp_path / "telemetry")
    packets = split(flight.stream)
    with open_bus(f"unix:{path}") as bus, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.bind(path + ".sender")
        sender.sendto(packets[0], path)
        assert bus.next_octets(5.0) == packets[0]
        assert bus.next_octets(4.0) is None  # 20 times silence: more than the sender's queue holds
        sender.sendto(packets[1], path)
        assert bus.next_octets(5.0) == packets[1]


def test_python_client_leaves_files_alone(tmp_path):
    from polhode_bus import open_bus

    file = tmp_path / "flight.ccsds"
    file.write_bytes(b"precious")
    with pytest.raises(FileExistsError, match="no socket"):
        open_bus(f"unix:{file}")
    assert file.read_bytes() == b"precious"


def test_a_full_queue_is_told_from_nobody(tmp_path):
    import socket

    path = str(tmp_path / "commands")
    words = "noop + noop + noop + noop + noop + noop + noop + noop + noop + noop + noop + noop + noop + noop".split()
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(path)
        done = subprocess.run([PROGRAM, "bus", "send", f"unix:{path}", *words], capture_output=True, text=True, timeout=60)
        assert done.returncode == 1 and "of 14 commands were sent" in done.stderr


def test_commands_are_sent_as_the_python_client_makes_them(tmp_path):
    import socket

    from polhode_bus import make_command, make_table_activate, make_table_load

    path = str(tmp_path / "commands")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(path)
        receiver.settimeout(20)
        words = ("set_range range_m=12.5 frame_timestamp_ns=7 + table_load features.count_max=500 features.sigma_px=0.3 + table_activate").split()
        subprocess.run([PROGRAM, "bus", "send", f"unix:{path}", *words], check=True, timeout=60)
        load = {"features.count_max": 500, "features.sigma_px": 0.3}
        assert receiver.recv(2000) == make_command("set_range", range_m=12.5, frame_timestamp_ns=7)
        assert receiver.recv(2000) == make_table_load(load)
        assert receiver.recv(2000) == make_table_activate([load])
    done = subprocess.run([PROGRAM, "bus", "send", f"unix:{tmp_path}/nobody", "noop"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "nobody takes commands" in done.stderr


def test_a_command_to_a_udp_port_of_nobody_fails(tmp_path):
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(20)
        port = receiver.getsockname()[1]
        done = subprocess.run([PROGRAM, "bus", "send", f"udp:127.0.0.1:{port}", "noop", "+", "noop"], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        assert receiver.recv(2000) and receiver.recv(2000)
    for words in (["noop"], ["noop", "+", "noop"]):
        done = subprocess.run([PROGRAM, "bus", "send", f"udp:127.0.0.1:{port}", *words], capture_output=True, text=True, timeout=60)
        assert done.returncode == 1 and done.stderr == f"polhode: udp:127.0.0.1:{port}: nobody takes commands there\n"


def test_words_are_loaded_as_such_and_counts_follow_each_other(tmp_path):
    import socket

    from polhode_bus import make_command, make_table_load

    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(str(tmp_path / "commands"))
        receiver.settimeout(20)
        words = "table_load motion.mode=paper mask.background=false + noop".split()
        subprocess.run([PROGRAM, "bus", "send", f"unix:{tmp_path}/commands", *words, "--sequence", "16383"], check=True, timeout=60)
        assert receiver.recv(2000) == make_table_load({"motion.mode": "paper", "mask.background": False}, sequence=16383)
        assert receiver.recv(2000) == make_command("noop", sequence=1)


def test_an_events_numbers_have_the_names_of_its_text(flight):
    from polhode_bus import name_of, numbers_of

    rows = {row["name"]: row for row in tomllib.loads((REPOSITORY / "config/bus/events.toml").read_text())["event"]}
    seen = set()
    for packet in flight.packets:
        if packet.name == "event" and not any(argument["type"] in ("text", "f64") for argument in rows[name_of(packet, "id")]["arguments"]):
            numbers = {name: int(value) for name, value in numbers_of(packet).items()}
            assert packet.text == rows[name_of(packet, "id")]["text"].format(**numbers)
            seen.add(name_of(packet, "id"))
    assert {"counters_reset", "table_loaded", "mode_changed"} & seen


def test_codes_are_printed_by_their_names(flight):
    from polhode_bus import name_of, words_of

    done = subprocess.run([PROGRAM, "bus", "dump", flight.file, "--json"], capture_output=True, text=True, check=True, timeout=60)
    printed = list(map(json.loads, done.stdout.splitlines()))
    for packet, ours in zip(printed, flight.packets, strict=True):
        if packet["packet"] == "event":
            assert packet["id_name"] == name_of(ours, "id") and packet.get("words", "") == words_of(ours)
        elif packet["packet"] == "housekeeping":
            assert packet["last_command_name"] == name_of(ours, "last_command")
    words = {packet["text"]: packet["words"] for packet in printed if packet.get("words")}
    assert words["command 6 set_range accepted"] == "set_range" and words["command 9 refused: entry"] == "table_load"
    names = {packet["id_name"] for packet in printed if packet["packet"] == "event"}
    assert {"noop", "command_accepted", "command_crc", "table_loaded", "table_refused", "table_activated", "checkpoint_asked"} <= names
    table = subprocess.run([PROGRAM, "bus", "dump", flight.file], capture_output=True, text=True, check=True, timeout=60).stdout
    assert " id=table_activated " in table and " last_command=checkpoint " in table and " last_command=noop " in table


def test_codes_of_events_are_printed_in_words():
    recorded = REPOSITORY / "tests/golden/x86_64/default.ccsds"
    done = subprocess.run([PROGRAM, "bus", "dump", recorded, "--json"], capture_output=True, text=True, check=True, timeout=60)
    changes = [event for event in map(json.loads, done.stdout.splitlines()) if event["packet"] == "event" and event["id"] == 9]
    assert changes and all(f"mode {int(event['value'][0])} to" in event["text"] for event in changes)
    names = ["IDLE", "ACQUIRING", "TRACKING", "LOST", "COASTING"]
    assert [event["words"] for event in changes] == [" to ".join(names[int(value)] for value in event["value"]) for event in changes]
    table = subprocess.run([PROGRAM, "bus", "dump", recorded], capture_output=True, text=True, check=True, timeout=60).stdout
    assert table.count('words="ACQUIRING to TRACKING"') >= 1


@pytest.mark.parametrize(("words", "says"), [
    ("set_range range_m=-1 frame_timestamp_ns=7", "command set_range: range_m = -1: allowed is 0.01 .. 100000 m\n"),
    ("request_cloud points_max=0", "command request_cloud: points_max = 0: allowed is 1 .. 100000\n"),
    ("servicer_attitude timestamp_ns=1 q_IC=1,1,0,0 w_C_rad_s=0,0,0",
     "command servicer_attitude: q_IC = 1,1,0,0: allowed is a quaternion whose norm is within 0.001 of 1\n"),
    ("servicer_attitude timestamp_ns=1 q_IC=1,0,0,0 w_C_rad_s=0,nan,0", "command servicer_attitude: w_C_rad_s = 0,nan,0: allowed is -10 .. 10 rad/s\n"),
    ("table_load features.sigma_px=0.3 features.count_max=5", "command table_load: features.count_max = 5: allowed is 50 .. 1000\n"),
    ("table_load features.sigma_px=0.3,0.4", "command table_load: features.sigma_px: 2 values, allowed is 1\n"),
    ("table_load motion.mode=fast", 'command table_load: motion.mode = fast: allowed are "dynamics", "paper"\n'),
    ("table_load seed=5", "command table_load: seed: does not change in flight"),
    ("noop + table_load features.sigma_px=nan", "command table_load: features.sigma_px = nan: allowed is 0.05 .. 5.0 px\n"),
])
def test_what_is_out_of_range_is_not_sent(tmp_path, words, says):
    import socket

    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(str(tmp_path / "commands"))
        receiver.setblocking(False)
        done = subprocess.run([PROGRAM, "bus", "send", f"unix:{tmp_path}/commands", *words.split()], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2 and says in done.stderr and done.stderr.count("\n") == 1, done.stderr
        with pytest.raises(BlockingIOError):
            receiver.recv(2000)


@pytest.fixture
def key(tmp_path):
    file = tmp_path / "commands.key"
    file.write_text("0123456789abcdef" * 4 + "\n")
    file.chmod(0o600)
    return file


def test_commands_are_signed_as_the_python_client_signs_them(tmp_path, key):
    import socket

    from polhode_bus import CommandSender, make_command, read_key, sign

    path = str(tmp_path / "commands")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(path)
        receiver.settimeout(20)
        words = "noop + set_range range_m=12.5 frame_timestamp_ns=7".split()
        subprocess.run([PROGRAM, "bus", "send", f"unix:{path}", *words, "--key", key, "--number", "77"], check=True, timeout=60)
        assert receiver.recv(2000) == sign(read_key(key), 77, make_command("noop"))
        assert receiver.recv(2000) == sign(read_key(key), 78, make_command("set_range", range_m=12.5, frame_timestamp_ns=7))
        before = time.time_ns()
        sender = CommandSender(f"unix:{path}", key=key)
        sender.send(make_command("noop"))
        sender.send(make_command("noop"))
        subprocess.run([PROGRAM, "bus", "send", f"unix:{path}", "noop", "--key", key], check=True, timeout=60)
        numbers = [int.from_bytes(receiver.recv(2000)[-24:-16], "big") for _ in range(3)]
        assert before <= numbers[0] < numbers[1] < numbers[2] <= time.time_ns()
        sender.close()


def test_a_key_that_others_may_read_signs_nothing(tmp_path, key):
    from polhode_bus import read_key

    key.chmod(0o644)
    done = subprocess.run([PROGRAM, "bus", "send", "udp:39220", "noop", "--key", key], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "mode 0600" in done.stderr
    with pytest.raises(PermissionError):
        read_key(key)
    key.chmod(0o600)
    key.write_text("no key")
    with pytest.raises(ValueError, match="hexadecimal"):
        read_key(key)
