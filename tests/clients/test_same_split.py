"""`bus follow`, `bus dump`, the C and the Python client cut the same octets into the same packets, and count the same beside them."""

import os
import re
import struct
import subprocess
import time

import pytest
from flights import PROGRAM, split

C_CLIENT = PROGRAM.parent / "bus_client_example"

pytestmark = pytest.mark.skipif(not C_CLIENT.exists(), reason=f"{C_CLIENT} is not built")

IDLE = b"\x07\xff\xc0\x00\x00\x0d" + b"\x55" * 14  # a CCSDS idle packet of 20 octets


def other(octets: int, apid: int = 0x123, kind: int = 0x0000) -> bytes:
    """Another application's, without our secondary header and without a CRC. @param kind 0x1000: a command"""
    return struct.pack(">HHH", kind | apid, 0xC005, octets - 7) + b"\xa5" * (octets - 6)


def renamed(packet: bytes, apid: int) -> bytes:
    """Our form, and so a wrong CRC, under another APID."""
    return struct.pack(">H", 0x0800 | apid) + packet[2:]


def cases(own: list[bytes]) -> dict[str, tuple]:
    """Name: octets, whole packets of ours in them, idle packets, others' packets, octets damaged."""
    a, b, c = own[:3]
    spoilt = b[:50] + bytes([b[50] ^ 4]) + b[51:]
    return {
        "several": (a + b + c, [a, b, c], 0, 0, 0),
        "idle before, between and behind": (IDLE + a + IDLE + IDLE + b + IDLE, [a, b], 4, 0, 0),
        "another application's before": (other(20) + a, [a], 0, 1, 0),
        "two applications between": (a + other(7, 0x050) + other(1000) + b, [a, b], 0, 2, 0),
        "our form under another APID": (a + renamed(b, 0x300) + c, [a, c], 0, 1, 0),
        "a command of another application": (other(12, kind=0x1000) + a, [a], 0, 1, 0),
        "no packet of ours": (other(30) + other(40, 0x700) + IDLE, [], 1, 2, 0),
        "another application's as long as may be": (other(4096) + a, [a], 0, 1, 0),
        "one octet longer": (a + other(4097) + b, [a, b], 0, 0, 4097),
        "cut off at the end": (a + other(30)[:-3], [a], 0, 0, 27),
        "behind damage only a CRC is believed": (b"\xe0junk" + other(30) + a, [a], 0, 0, 35),
        "damage that ends with a packet of ours": (a + b"\xe0" + b + other(30) + c, [a, b, c], 0, 1, 1),
        "our APID with a wrong CRC": (a + spoilt + c, [a, c], 0, 0, len(b)),
        "ours cut off": (a[:100] + b, [b], 0, 0, 100),
        "a hole of zeros": (bytes(70) + a, [a], 0, 0, 70),
        "all kinds": (IDLE + other(20) + a + b"\xff" + b + IDLE + other(9), [a, b], 2, 2, 1),
    }


def told(text: str) -> tuple[int, int, int, int]:
    """Packets, idle, others, damaged octets, as the program says at its end."""
    packets, damaged = re.search(r"(\d+) packets, \d+ missing by their counts, (\d+) octets damaged", text).groups()
    passed = re.search(r"passed over: (\d+) idle packets, (\d+) of other applications", text)
    return int(packets), *(map(int, passed.groups()) if passed else (0, 0)), int(damaged)


def told_by_example(text: str) -> tuple[int, int, int, int]:
    """As told(), of the C example's last lines."""
    packets = int(re.search(r"(\d+) packets, \d+ missing", text)[1])
    more = re.search(r"(\d+) octets damaged; passed over: (\d+) idle packets, (\d+) of other", text)
    damaged, idle, foreign = map(int, more.groups()) if more else (0, 0, 0)
    return packets, idle, foreign, damaged


def started(command: list, name: str, tmp_path) -> subprocess.Popen:
    with open(tmp_path / name, "wb") as out:
        return subprocess.Popen([str(word) for word in command], stdout=out, stderr=subprocess.PIPE, text=True)


def deliver(path: str, octets: bytes) -> None:
    import socket

    end = time.monotonic() + 60.0
    while not os.path.exists(path):
        assert time.monotonic() < end, path
        time.sleep(0.01)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.settimeout(20.0)
        sender.sendto(octets, path)


def test_all_four_split_the_same_octets_alike(flight, tmp_path):
    from polhode_bus import open_bus

    table = cases([packet for packet in split(flight.stream) if len(packet) == len(split(flight.stream)[0])])
    running = []
    for number, (octets, *_) in enumerate(table.values()):
        follow = f"unix:{tmp_path}/f{number}"
        client = f"unix:{tmp_path}/c{number}"
        running.append((started([PROGRAM, "bus", "follow", follow, "--json", "--timeout", "3"], f"follow{number}", tmp_path),
                        started([C_CLIENT, client], f"client{number}", tmp_path)))
        deliver(follow[5:], octets)
        deliver(client[5:], octets)
    for number, (name, (octets, whole, idle, foreign, damaged)) in enumerate(table.items()):
        expected = (len(whole), idle, foreign, damaged)
        with open_bus(f"unix:{tmp_path}/p{number}") as bus:
            deliver(f"{tmp_path}/p{number}", octets)
            got = []
            while (packet := bus.next_octets(0.01)) is not None:
                got.append(packet)
            assert got == whole and (len(got), bus.idle, bus.foreign, bus.damaged) == expected, name
        file = tmp_path / f"{number}.ccsds"
        file.write_bytes(octets)
        dumped = subprocess.run([PROGRAM, "bus", "dump", file, "--json"], capture_output=True, text=True, timeout=60)
        assert told(dumped.stderr) == expected, name
        follow, client = running[number]
        _, err = follow.communicate(timeout=60)
        assert told(err) == expected and (tmp_path / f"follow{number}").read_text() == dumped.stdout, name
        client.communicate(timeout=60)
        assert told_by_example((tmp_path / f"client{number}").read_text()) == expected, name


def test_another_first_apid_makes_its_damage_damage(flight, tmp_path):
    from polhode_bus import open_bus

    a, b, c = split(flight.stream)[:3]
    octets = a + renamed(b, 0x300) + c
    file = tmp_path / "stream.ccsds"
    file.write_bytes(octets)
    dumped = subprocess.run([PROGRAM, "bus", "dump", file, "--apid-first", str(0x300)], capture_output=True, text=True, timeout=60)
    assert told(dumped.stderr) == (2, 0, 0, len(b))
    with open_bus(f"unix:{tmp_path}/p", apid_first=0x300) as bus:
        deliver(f"{tmp_path}/p", octets)
        assert [bus.next_octets(0.1), bus.next_octets(0.1)] == [a, c] and (bus.foreign, bus.damaged) == (0, len(b))
