"""Where packets come from: sockets, shared memory, files."""

import contextlib
import mmap
import os
import socket
import stat
import struct
import time

from .decode import HEADER_OCTETS, PACKET_OCTETS_MAX, Packet, crc16, decode, header_of
from .packets import APID_COMMAND, APID_FIRST

_RING_MAGIC = 0x31474E5248444C50
_RING_HEADER = 128  # octets; the count of packets written is at 64
_RING_WORDS = 175  # of a slot's packet
_RING_SLOT = 1472  # octets, a multiple of 64
_POLL_S = 0.001
_SILENCE_S = 0.2  # after which a sender may have died
_SKIPPED_OCTETS_MAX = 4096  # a longer packet could hide others
_LOOK_AHEAD = 4  # packets; each makes an accident some ten times less likely


def _idle_at(octets: bytes) -> int | None:
    """Octets of the idle packet (APID 0x7FF) at the front; 0: more are needed to tell; None: there is none."""
    if octets[0] != 0x07 or octets[1:2] not in (b"", b"\xff") or (len(octets) > 2 and octets[2] & 0xC0 != 0xC0):
        return None
    if len(octets) < 6:
        return 0
    count = struct.unpack_from(">H", octets, 4)[0] + 7
    if count > _SKIPPED_OCTETS_MAX:
        return None
    if len(octets) < count:
        return 0
    following = octets[count:count + 1]
    return count if not following or following[0] == 0x07 or following[0] & 0xF8 == 0x08 else None


def _owner_of(header: bytes, apid_first: int) -> str | None:
    """Whose a primary header may be: of the run, an idle packet's (fill), of another application; None: it is none."""
    apid, unsegmented = int.from_bytes(header[:2], "big") & 0x7FF, header[2] & 0xC0 == 0xC0
    if header[0] & 0xE0:  # the version
        return None
    if apid == 0x7FF:
        return "fill" if header[0] == 0x07 and unsegmented else None
    if apid_first <= apid <= apid_first + APID_COMMAND and not header[0] & 0x10:
        return "run" if header[0] & 0xF8 == 0x08 and unsegmented else None
    return "other" if any(header) else None  # a hole in a file reads as zeros


def _skipped_at(octets: bytes, apid_first: int, at_end: bool) -> int | None:
    """As _idle_at(), of a packet of another application without our secondary header or CRC, or of an idle one before such. Its primary
    header tells it, and those of a few packets behind it, followed from length to length."""
    undecided = None if at_end else 0
    first = at = 0
    for i in range(_LOOK_AHEAD):
        if i and at == len(octets):
            return first if at_end else 0
        if len(octets) - at < 6:
            return undecided
        owner = _owner_of(octets[at:at + 6], apid_first)
        if i and owner in ("run", "fill"):
            return first
        count = struct.unpack_from(">H", octets, at + 4)[0] + 7
        if owner in (None, "run") or count > _SKIPPED_OCTETS_MAX:
            return None
        first = first or count
        at += count
        if at > len(octets):
            return undecided
    return first


def _packet_at(octets: bytes) -> int | None:
    """As _idle_at(), of a packet whose CRC is right."""
    for at, mask, value in ((0, 0xF8, 0x08), (2, 0xC0, 0xC0), (6, 0xFF, 0x2F)):
        if len(octets) > at and octets[at] & mask != value:
            return None
    if len(octets) < HEADER_OCTETS:
        return 0
    header = header_of(octets[:HEADER_OCTETS])
    if header is None or not 18 < header.octets <= PACKET_OCTETS_MAX:
        return None
    if len(octets) < header.octets:
        return 0
    return header.octets if crc16(octets[:header.octets]) == 0 else None


class _Cutter:
    """Octets that arrive in pieces, cut into packets: several in a datagram, in between idle ones and those of other applications."""

    def __init__(self, apid_first: int):
        self.held = b""
        self.in_step = True  # packets were whole up to here
        self.damaged_octets = self.idle = self.foreign = 0
        self._apid_first = apid_first

    def packet(self, at_end: bool) -> bytes | None:
        """The next whole packet of what is held; None: more is needed. Another application's packet is believed only where packets were
        whole up to it. @param at_end nothing will follow."""
        while self.held:
            whole = _packet_at(self.held)
            if whole:
                packet, self.held, self.in_step = self.held[:whole], self.held[whole:], True
                return packet
            idle = _idle_at(self.held)
            if not at_end and 0 in (whole, idle):
                return None
            skipped = idle or (_skipped_at(self.held, self._apid_first, at_end) if self.in_step else None)
            if skipped == 0 and not at_end:
                return None
            self.in_step = bool(skipped)
            if not skipped:
                self.damaged_octets += 1
            elif self.held[:2] == b"\x07\xff":
                self.idle += 1
            else:
                self.foreign += 1
            self.held = self.held[skipped or 1:]
        return None


class _Datagrams:
    def __init__(self, kind: str, rest: str):
        self._path = rest if kind == "unix" else None
        self._connected = False
        self._heard_s = 0.0
        self._socket = socket.socket(socket.AF_UNIX if kind == "unix" else socket.AF_INET, socket.SOCK_DGRAM)
        if kind == "udp":
            host, _, port = rest.rpartition(":")
            self._socket.bind((host or "127.0.0.1", int(port)))
            return
        with contextlib.suppress(FileNotFoundError):
            self._remove_if_dead(rest)
        before = os.umask(0o177)  # the socket's file is its owner's alone
        try:
            self._socket.bind(rest)
        finally:
            os.umask(before)

    @staticmethod
    def _remove_if_dead(path: str) -> None:
        if not stat.S_ISSOCK(os.lstat(path).st_mode):
            raise FileExistsError(f"unix:{path}: is there and is no socket")
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(path)
            except ConnectionRefusedError:
                os.unlink(path)

    def _connect_to(self, sender: str | bytes | None) -> None:
        """The system holds 10 datagrams of a stranger, of the one that the socket is connected to hundreds."""
        if self._path and sender and not self._connected:
            with contextlib.suppress(OSError):
                self._socket.connect(sender)
                self._connected = True

    def _let_go_of_dead(self) -> None:
        """The system itself undoes the connection to a dead sender when it is sent to."""
        self._socket.setblocking(False)  # with a time limit, sending to a full queue waits for it
        try:
            self._socket.send(b"")
        except ConnectionRefusedError:
            self._connected = False
        except BlockingIOError:
            pass

    def read(self, timeout_s: float) -> bytes | None:
        left_s = max(timeout_s, 1e-6)
        while True:
            slice_s = min(left_s, _SILENCE_S) if self._connected else left_s
            self._socket.settimeout(slice_s)
            try:
                octets, sender = self._socket.recvfrom(65536)
                self._connect_to(sender)
                self._heard_s = time.monotonic()
                return octets
            except TimeoutError:
                if self._connected and time.monotonic() - self._heard_s >= _SILENCE_S:
                    self._let_go_of_dead()
                left_s -= slice_s
                if left_s <= 0.0:
                    return None

    def close(self) -> None:
        self._socket.close()
        if self._path:
            os.unlink(self._path)


class _Ring:
    """See platform/transport/shm/ring_layout.hpp."""

    def __init__(self, name: str):
        with open(os.open(f"/dev/shm{name}", os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            status = os.fstat(file.fileno())
            # As the writer makes it. Of another user, or open to others, it could hold anything.
            if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid() or status.st_mode & 0o077:
                raise PermissionError(f"shm:{name}: belongs to another user, or is open to others")
            if status.st_size < _RING_HEADER:
                raise ValueError(f"shm:{name} is no ring of packets")
            self._memory = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)
        magic, self._slots, self._slot_octets, words = struct.unpack_from("=4Q", self._memory)
        whole = _RING_HEADER + self._slots * self._slot_octets <= status.st_size
        if magic != _RING_MAGIC or words != _RING_WORDS or self._slot_octets != _RING_SLOT or not whole:
            raise ValueError(f"shm:{name} is no ring of packets")
        self._next = self._head()
        self.overrun = 0

    def _word(self, at: int) -> int:
        return struct.unpack_from("=Q", self._memory, at)[0]

    def _head(self) -> int:
        return self._word(64)

    def _slot(self) -> bytes | None:
        """Packet self._next; None where it was overwritten."""
        at = _RING_HEADER + self._next % self._slots * self._slot_octets
        version, octets = self._word(at), min(self._word(at + 8), PACKET_OCTETS_MAX)
        packet = bytes(self._memory[at + 16:at + 16 + octets])
        return packet if version == self._word(at) == 2 * self._next + 2 else None

    def read(self, timeout_s: float) -> bytes | None:
        until = time.monotonic() + timeout_s
        while True:
            head = self._head()
            if self._next < head:
                packet = self._slot() if head - self._next <= self._slots else None
                if packet is not None:
                    self._next += 1
                    return packet
                to = max(self._next + 1, head - self._slots // 2)
                self.overrun += to - self._next
                self._next = to
            elif time.monotonic() >= until:
                return None
            else:
                time.sleep(_POLL_S)

    def close(self) -> None:
        self._memory.close()


class _File:
    def __init__(self, path: str, apid_first: int):
        self._file = open(path, "rb")
        self.cutter = _Cutter(apid_first)

    def read(self, timeout_s: float) -> bytes | None:
        until = time.monotonic() + timeout_s
        while True:
            packet = self.cutter.packet(at_end=False)
            if packet is not None:
                return packet
            more = self._file.read(1 << 16)
            self.cutter.held += more
            if not more:
                if time.monotonic() >= until:
                    return None
                time.sleep(0.01)

    def close(self) -> None:
        self._file.close()


class Bus:
    """A reader's end. What was lost is counted: `missing` by the packets' counts, `damaged` octets. What was passed over is counted,
    too: `idle` packets, and those of other applications without our secondary header or CRC (`foreign`)."""

    def __init__(self, source, apid_first: int = APID_FIRST):
        self._source = source
        self._cutter = _Cutter(apid_first)  # of the last datagram
        self._cutters = [self._cutter, *([source.cutter] if hasattr(source, "cutter") else [])]
        self._last = {}
        self.missing = 0

    @property
    def damaged(self) -> int:
        return sum(cutter.damaged_octets for cutter in self._cutters)

    @property
    def idle(self) -> int:
        return sum(cutter.idle for cutter in self._cutters)

    @property
    def foreign(self) -> int:
        return sum(cutter.foreign for cutter in self._cutters)

    def next_octets(self, timeout_s: float) -> bytes | None:
        """The next packet whose CRC is right; None when none came in time (of a file: its end for now)."""
        while (octets := self._cutter.packet(at_end=True)) is None:
            octets = self._source.read(timeout_s)
            if octets is None:
                return None
            self._cutter.held, self._cutter.in_step = octets, True
        header = header_of(octets)
        last = self._last.get(header.apid)
        self.missing += 0 if last is None else (header.sequence - last - 1) % 16384
        self._last[header.apid] = header.sequence
        return octets

    def packets(self, timeout_s: float = 0.0):
        """Packets of the field table, decoded, until none comes for timeout_s."""
        while (octets := self.next_octets(timeout_s)) is not None:
            packet = decode(octets)
            if packet is not None:
                yield packet

    def close(self) -> None:
        self._source.close()

    def __enter__(self) -> "Bus":
        return self

    def __exit__(self, *_) -> None:
        self.close()


def open_bus(address: str, apid_first: int = APID_FIRST) -> Bus:
    """unix:PATH and udp:PORT or udp:HOST:PORT are bound here; shm:/NAME and file:PATH are opened. Another run's bus.apid_first may be given."""
    kind, _, rest = address.partition(":")
    if kind in ("unix", "udp"):
        return Bus(_Datagrams(kind, rest), apid_first)
    if kind == "shm":
        return Bus(_Ring(rest), apid_first)
    if kind == "file":
        return Bus(_File(rest, apid_first), apid_first)
    raise ValueError(f"{address}: allowed are unix:PATH, udp:PORT, udp:HOST:PORT, shm:/NAME, file:PATH")
