"""Commands as octets."""

import binascii
import socket
import struct

from .decode import crc16
from .packets import APID_COMMAND, APID_FIRST, COMMANDS, LAYOUT_VERSION
from .parameters import PARAMETERS
from .signing import next_number, read_key, sign

_BY_NAME = {row[0]: (code, row) for code, row in COMMANDS.items()}


def _packet(code: int, arguments: bytes, apid_first: int, sequence: int) -> bytes:
    if not 0 <= sequence < 0x4000:
        raise ValueError(f"sequence = {sequence}: allowed are 0 .. {0x3FFF}")
    octets = struct.pack(">HHHBB", 0x1800 | (apid_first + APID_COMMAND), 0xC000 | sequence, len(arguments) + 3, LAYOUT_VERSION, code) + arguments
    return octets + struct.pack(">H", crc16(octets))


def make_command(name: str, apid_first: int = APID_FIRST, sequence: int = 0, **arguments) -> bytes:
    """A command by its name in the field table, as in make_command("set_range", frame_timestamp_ns=5, range_m=12.0).
    sequence: its count, 1 .. 16383: sent again as it is, it is answered but not carried out again. 0: it has none.
    Ranges are checked by the receiver. Raises TypeError for arguments that are missing or not the command's."""
    code, (_, _, _, rows) = _BY_NAME[name]
    packed = b""
    for row in rows:
        default = [0] * row[2] if row[4] else 0
        value = default if row[0] == "spare" else arguments.pop(row[0], None)
        if value is None:
            raise TypeError(f"{name}: {row[0]} is missing")
        packed += struct.pack(f">{row[2]}{row[1]}", *(value if row[4] else [value]))
    if arguments:
        raise TypeError(f"{name}: has no {', '.join(arguments)}")
    return _packet(code, packed, apid_first, sequence)


def _bits(key: str, value) -> bytes:
    """The value as the parameter's type has it. Raises ValueError where it is not one that the parameter may have."""
    if key not in PARAMETERS:
        raise ValueError(f"{key}: no parameter that a command may change")
    kind, limits, words = PARAMETERS[key]
    if words:
        word = str(value).lower() if isinstance(value, bool) else value
        if word not in words:
            raise ValueError(f"{key} = {value}: allowed are {', '.join(words)}")
        return struct.pack(">q", words.index(word))
    if not limits[0] <= value <= limits[1] or (kind == "i64" and int(value) != value):
        raise ValueError(f"{key} = {value}: allowed are {limits[0]} .. {limits[1]}")
    return struct.pack(">d", value) if kind == "f64" else struct.pack(">q", int(value))


def table_entries(values: dict) -> bytes:
    """Parameters by dotted key: numbers, True and False, or words."""
    return b"".join(struct.pack(">IHH", binascii.crc32(key.encode()), 0, 0) + _bits(key, value) for key, value in values.items())


def make_table_load(values: dict, apid_first: int = APID_FIRST, sequence: int = 0) -> bytes:
    """TABLE_LOAD of up to 64 parameters, as in make_table_load({"features.count_max": 500}).
    Raises ValueError naming the parameter, its value and what is allowed."""
    return _packet(_BY_NAME["table_load"][0], struct.pack(">HHHH", len(values), 0, 0, 0) + table_entries(values), apid_first, sequence)


def make_table_activate(loads: list, apid_first: int = APID_FIRST, sequence: int = 0) -> bytes:
    """TABLE_ACTIVATE of what these make_table_load() calls loaded, given their arguments in order."""
    octets = b"".join(map(table_entries, loads))
    return make_command("table_activate", apid_first, sequence, crc32=binascii.crc32(octets), entries=sum(map(len, loads)))


class CommandSender:
    """Sends to unix:PATH, udp:PORT or udp:HOST:PORT; signed where a key file is given (commands.key of the run)."""

    def __init__(self, address: str, key=None):
        self._key, self._number = read_key(key) if key else None, 0
        kind, _, rest = address.partition(":")
        if kind == "unix":
            self._socket, self._to = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM), rest
        elif kind == "udp":
            host, _, port = rest.rpartition(":")
            self._socket, self._to = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), (host or "127.0.0.1", int(port))
        else:
            raise ValueError(f"{address}: allowed are unix:PATH, udp:PORT, udp:HOST:PORT")

    def send(self, octets: bytes) -> None:
        if self._key:
            self._number = next_number(self._number)
            octets = sign(self._key, self._number, octets)
        self._socket.sendto(octets, self._to)

    def close(self) -> None:
        self._socket.close()
