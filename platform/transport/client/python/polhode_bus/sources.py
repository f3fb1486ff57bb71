"""Where packets come from: sockets, shared memory, files."""

import contextlib
import mmap
import os
import socket
import stat
import struct
import time

from .decode import PACKET_OCTETS_MAX, Packet, crc16, decode, header_of

_RING_MAGIC = 0x31474E5248444C50
_RING_HEADER = 128  # octets; the count of packets written is at 64
_POLL_S = 0.001
_SILENCE_S = 0.2  # after which a sender may have died


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
                octets, sender = self._socket.recvfrom(PACKET_OCTETS_MAX + 1)
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
        with open(f"/dev/shm{name}", "rb") as file:
            self._memory = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)
        magic, self._slots, self._slot_octets, _ = struct.unpack_from("=4Q", self._memory)
        if magic != _RING_MAGIC:
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
    def __init__(self, path: str):
        self._file = open(path, "rb")
        self._held = b""
        self.damaged_octets = 0

    def _cut(self) -> bytes | None:
        """The next whole packet of what is held; None: more is needed."""
        at = 0
        while len(self._held) - at >= 16:
            header = header_of(self._held[at:at + 16])
            if header is None or not 18 < header.octets <= PACKET_OCTETS_MAX:
                at += 1
                continue
            packet = self._held[at:at + header.octets]
            if len(packet) < header.octets:
                break
            if crc16(packet) == 0:
                self._drop(at, header.octets)
                return packet
            at += 1
        self._drop(at, 0)
        return None

    def _drop(self, damaged: int, whole: int) -> None:
        self.damaged_octets += damaged
        self._held = self._held[damaged + whole:]

    def read(self, timeout_s: float) -> bytes | None:
        until = time.monotonic() + timeout_s
        while True:
            packet = self._cut()
            if packet is not None:
                return packet
            more = self._file.read(1 << 16)
            self._held += more
            if not more:
                if time.monotonic() >= until:
                    return None
                time.sleep(0.01)

    def close(self) -> None:
        self._file.close()


class Bus:
    """A reader's end. What was lost is counted: `missing` by the packets' counts, `damaged` datagrams or octets."""

    def __init__(self, source):
        self._source = source
        self._last = {}
        self.missing = 0
        self._damaged = 0

    @property
    def damaged(self) -> int:
        return self._damaged + getattr(self._source, "damaged_octets", 0)

    def next_octets(self, timeout_s: float) -> bytes | None:
        """The next packet whose CRC is right; None when none came in time (of a file: its end for now)."""
        while True:
            octets = self._source.read(timeout_s)
            if octets is None:
                return None
            header = header_of(octets)
            if header is not None and header.octets == len(octets) and crc16(octets) == 0:
                last = self._last.get(header.apid)
                self.missing += 0 if last is None else (header.sequence - last - 1) % 16384
                self._last[header.apid] = header.sequence
                return octets
            self._damaged += 1

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


def open_bus(address: str) -> Bus:
    """unix:PATH and udp:PORT or udp:HOST:PORT are bound here; shm:/NAME and file:PATH are opened."""
    kind, _, rest = address.partition(":")
    if kind in ("unix", "udp"):
        return Bus(_Datagrams(kind, rest))
    if kind == "shm":
        return Bus(_Ring(rest))
    if kind == "file":
        return Bus(_File(rest))
    raise ValueError(f"{address}: allowed are unix:PATH, udp:PORT, udp:HOST:PORT, shm:/NAME, file:PATH")
