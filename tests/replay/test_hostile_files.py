"""Files that are none, text in other encodings, and messages that have to quote what was in them."""

import binascii
import json
import os
import socket
import struct
import subprocess

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM

LIMIT_S = 20
# Root may read every file; without these two rights it may as little as anybody.
AS_ANYBODY = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"] if os.geteuid() == 0 else []


def call(*arguments) -> subprocess.CompletedProcess:
    return subprocess.run([*AS_ANYBODY, PROGRAM, *map(str, arguments)], capture_output=True, timeout=LIMIT_S)


def one_line(done: subprocess.CompletedProcess, *parts) -> str:
    assert done.returncode == 2, done.stderr
    text = done.stderr.decode()  # UTF-8, whatever was in the file
    lines = text.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("polhode: "), text
    assert all(part in lines[0] for part in parts), text
    assert lines[0].isprintable() and len(lines[0]) < 900, text
    return lines[0]


def fifo(path):
    os.mkfifo(path)


def folder(path):
    path.mkdir()


def broken_link(path):
    path.symlink_to(path.with_name("nowhere"))


def device(path):
    path.symlink_to("/dev/zero")


def connection(path):
    kept = socket.socket(socket.AF_UNIX)
    here = os.getcwd()
    os.chdir(path.parent)  # its name may be no longer than 107 octets
    try:
        kept.bind(path.name)
    finally:
        os.chdir(here)
    kept.close()


def unreadable(path):
    path.write_text("x")
    path.chmod(0)


NO_FILES = [fifo, folder, broken_link, device, connection, unreadable]
PLACES = ["data.csv", "sensor.yaml", "servicer_attitude.csv", "commands", "config", "checkpoint", "dump"]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("make", NO_FILES)
def test_what_is_no_file_is_refused_at_once(sequence, tmp_path, make, place):
    at = {"data.csv": sequence.camera / "data.csv", "sensor.yaml": sequence.camera / "sensor.yaml",
          "servicer_attitude.csv": sequence.path / "servicer_attitude.csv"}.get(place, tmp_path / place)
    at.unlink(missing_ok=True)
    make(at)
    replay = ["replay", "--config", at if place == "config" else DEFAULTS, "--sequence", sequence.path, "--out", tmp_path / "out"]
    more = {"commands": ["--commands", at], "checkpoint": ["--checkpoint", at]}
    one_line(call("bus", "dump", at) if place == "dump" else call(*replay, *more.get(place, [])), str(at))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("make", NO_FILES)
def test_a_picture_that_is_no_file_is_a_frame_that_is_not_used(sequence, tmp_path, make):
    picture = sequence.data / sequence.rows[1][1]
    picture.unlink()
    make(picture)
    done = call("replay", "--config", DEFAULTS, "--sequence", sequence.path, "--out", tmp_path / "out")
    assert done.returncode == 0 and b"frame 1 is not used" in done.stderr


def table_of(sequence) -> str:
    return (sequence.camera / "data.csv").read_text()


@pytest.mark.parametrize("encode", [lambda text: b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode(),
                                    lambda text: text.replace("\n", "\r").encode()], ids=["byte_order_mark", "carriage_returns"])
def test_other_line_ends_and_marks_are_read(sequence, tmp_path, encode):
    (sequence.camera / "data.csv").write_bytes(encode(table_of(sequence)))
    commands = tmp_path / "commands"
    commands.write_bytes(encode(f"# when what\n{sequence.rows[0][0]} hold\n{sequence.rows[1][0]} resume\n"))
    done = call("replay", "--config", DEFAULTS, "--sequence", sequence.path, "--out", tmp_path / "out", "--commands", commands)
    assert done.returncode == 0, done.stderr
    counters = json.loads((tmp_path / "out/summary.json").read_text())["counters"]
    assert counters["frames_in"] == len(sequence.rows) and counters["frames_held"] == 1


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_utf_16_is_named(sequence, tmp_path, encoding):
    mark = b"\xfe\xff" if encoding == "utf-16-be" else b""
    (sequence.camera / "data.csv").write_bytes(mark + table_of(sequence).encode(encoding))
    one_line(call("replay", "--config", DEFAULTS, "--sequence", sequence.path, "--out", tmp_path / "out"), "data.csv: is UTF-16; allowed is UTF-8")


HOSTILE = b"\x1b[31m\x00\xff" + b"y" * 100_000


@pytest.mark.parametrize("place", ["data.csv", "sensor.yaml", "commands", "key", "value", "setting", "servicer_attitude.csv"])
def test_a_message_quotes_little_and_only_what_can_be_printed(sequence, tmp_path, place):
    config, more = DEFAULTS, []
    if place == "data.csv":
        (sequence.camera / "data.csv").write_bytes(HOSTILE + b"\n")
    elif place == "sensor.yaml":
        (sequence.camera / "sensor.yaml").write_text((sequence.camera / "sensor.yaml").read_text().replace("pinhole", "y" * 100_000))
    elif place == "servicer_attitude.csv":
        (sequence.path / "servicer_attitude.csv").write_bytes(b"#\n" + HOSTILE + b"\n")
    elif place == "commands":
        (tmp_path / "commands").write_bytes(b"1 " + HOSTILE + b"\n")
        more = ["--commands", tmp_path / "commands"]
    elif place == "setting":
        more = ["--set", "mask." + "y" * 10_000 + "=1"]
    else:
        config = tmp_path / "config.toml"
        config.write_text({"key": "[mask]\n" + "y" * 100_000 + " = 1\n", "value": f'[features]\ncount_max = "{"y" * 100_000}"\n'}[place])
    line = one_line(call("replay", "--config", config, "--sequence", sequence.path, "--out", tmp_path / "out", *more))
    assert line.count("y") < 750


def test_a_name_of_a_picture_that_is_no_text_ends_no_summary(sequence, tmp_path):
    with (sequence.camera / "data.csv").open("ab") as table:
        table.write(b"9000000000,\xff\x1b.png\n")
    done = call("replay", "--config", DEFAULTS, "--sequence", sequence.path, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert rb"\xff\x1b.png" in done.stderr and json.loads((tmp_path / "out/summary.json").read_text())


def test_text_of_an_event_that_is_no_text_ends_no_dump(replay, sequence, tmp_path):
    """The text's first octet becomes 0xFF, and the packet's CRC goes along."""
    octets = bytearray((replay(sequence.path).folder / "bus.ccsds").read_bytes())
    at = octets.index(b"started")
    first = 0
    while first + 7 + struct.unpack_from(">H", octets, first + 4)[0] <= at:
        first += 7 + struct.unpack_from(">H", octets, first + 4)[0]
    end = first + 7 + struct.unpack_from(">H", octets, first + 4)[0]
    octets[at] = 0xFF
    octets[end - 2:end] = struct.pack(">H", binascii.crc_hqx(bytes(octets[first:end - 2]), 0xFFFF))
    file = tmp_path / "b.ccsds"
    file.write_bytes(octets)
    for form in ([], ["--json"]):
        whole = call("bus", "dump", replay(sequence.path).folder / "bus.ccsds", *form).stdout.splitlines()
        got = call("bus", "dump", file, *form)
        assert got.returncode == 0 and len(got.stdout.splitlines()) == len(whole)
        assert got.stdout.decode()
