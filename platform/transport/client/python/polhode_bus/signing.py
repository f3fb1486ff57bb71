"""The trailer of a signed command. docs/security.md has the reasons; polhode_sign.h is the same in C."""

import hashlib
import hmac
import os
import re
import stat
import struct
import time

MAC_OCTETS = 16
TRAILER_OCTETS = 8 + MAC_OCTETS


def read_key(file) -> bytes:
    """Of a key file: 64 hexadecimal digits, its owner's alone. Raises ValueError or PermissionError."""
    with open(os.open(file, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK), "rb") as opened:
        status = os.fstat(opened.fileno())
        if not stat.S_ISREG(status.st_mode) or status.st_mode & 0o077 or status.st_uid not in (os.geteuid(), 0):
            raise PermissionError(f"{file}: a key is a file of its own user's or root's, of mode 0600 or 0400")
        text = opened.read(66)
    if not re.fullmatch(rb"[0-9A-Fa-f]{64}\n?", text):
        raise ValueError(f"{file}: allowed are 64 hexadecimal digits, as `openssl rand -hex 32` gives")
    return bytes.fromhex(text.decode())


def next_number(last: int = 0) -> int:
    """Greater than `last`, and the UTC time in ns wherever that is greater."""
    return max(time.time_ns(), last + 1)


def sign(key: bytes, number: int, packet: bytes) -> bytes:
    """The command packet with its trailer: number and MAC. Its header's length counts them."""
    if len(packet) < 7 or struct.unpack_from(">H", packet, 4)[0] + 7 != len(packet):
        raise ValueError("no command packet")
    body = packet[:4] + struct.pack(">H", len(packet) + TRAILER_OCTETS - 7) + packet[6:] + struct.pack(">Q", number)
    return body + hmac.new(key, body, hashlib.sha256).digest()[:MAC_OCTETS]
