"""Spoils an input: octets, lengths, numbers, whole lines; where it has checksums, these are made right again half of the time."""

import random
import re
import struct
import zlib

WORDS = [b"nan", b"inf", b"-1", b"0", b"1e999", b"-0.0", b"9" * 30, b"99999999999999999999", b"2147483648", b"4294967296", b"\x00", b"\xff" * 8,
         b"\xef\xbb\xbf", b"\r", b"\n\n", b",", b"[", b"{" * 50, b'"', b"#", b"..", b"/", b"%s%n", b"\x1b[2J", b"\xc3\x28", b"A" * 3000]
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?")


def flip(data: bytearray, rng: random.Random) -> None:
    for _ in range(rng.choice([1, 1, 2, 8, 64])):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def overwrite(data: bytearray, rng: random.Random) -> None:
    width = rng.choice([1, 2, 4, 8])
    at = rng.randrange(len(data))
    value = rng.choice([0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, rng.getrandbits(64)]) & (256**width - 1)
    data[at:at + width] = value.to_bytes(width, rng.choice(["little", "big"]))


def cut(data: bytearray, rng: random.Random) -> None:
    del data[rng.randrange(len(data)):]


def remove(data: bytearray, rng: random.Random) -> None:
    at = rng.randrange(len(data))
    del data[at:at + rng.choice([1, 2, 7, 100])]


def repeat(data: bytearray, rng: random.Random) -> None:
    at, count = rng.randrange(len(data)), rng.choice([1, 4, 64, 1000])
    data[at:at] = data[at:at + count] * rng.choice([1, 2, 20])


def insert(data: bytearray, rng: random.Random) -> None:
    at = rng.randrange(len(data))
    data[at:at] = rng.choice(WORDS)


def renumber(data: bytearray, rng: random.Random) -> None:
    found = list(NUMBER.finditer(data))
    if found:
        place = rng.choice(found)
        data[place.start():place.end()] = rng.choice(WORDS[:10])


def swap(data: bytearray, rng: random.Random) -> None:
    lines = bytes(data).splitlines(keepends=True)
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    data[:] = b"".join(lines)


KINDS = [flip, flip, overwrite, overwrite, cut, remove, repeat, insert, renumber, swap]


def checkpoint_sums(data: bytearray) -> None:
    """platform/app/checkpoint_file.cpp: header of 240 octets, content's CRC at 128, its length at 192, the header's CRC at its end."""
    if len(data) > 240:
        struct.pack_into("<I", data, 128, zlib.crc32(data[240:]))
        struct.pack_into("<Q", data, 192, len(data) - 240)
        struct.pack_into("<I", data, 236, zlib.crc32(data[:236]))


def recording_sums(data: bytearray) -> None:
    """platform/recording/record.cpp: headers of 40 octets with their CRC at the end; content's length at 24, its CRC at 28."""
    at = 0
    while at + 40 <= len(data):
        octets = min(struct.unpack_from("<I", data, at + 24)[0], len(data) - at - 40)
        struct.pack_into("<II", data, at + 24, octets, zlib.crc32(data[at + 40:at + 40 + octets]))
        struct.pack_into("<I", data, at + 36, zlib.crc32(data[at:at + 36]))
        at += 40 + octets


def spoilt(data: bytes, rng: random.Random, sums=None) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        if out:
            rng.choice(KINDS)(out, rng)
    if sums and out and rng.random() < 0.5:
        sums(out)
    return bytes(out)
