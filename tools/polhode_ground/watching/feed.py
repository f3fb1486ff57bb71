"""Takes packets as fast as they come, in a thread of its own: a slow page makes nobody wait, and sees the newest."""

import contextlib
import os
import pathlib
import threading
import time

from polhode_bus import Bus, decode, open_bus

from polhode_ground.common.errors import BadInput
from polhode_ground.watching.state import State

ALLOWED = "allowed are unix:PATH, udp:PORT, udp:HOST:PORT (bound here), shm:/NAME, file:PATH"
WAIT_S = 0.2


def check_address(address: str) -> None:
    """@errors BadInput: a form that readers of the bus do not take."""
    kind, _, rest = address.partition(":")
    port = rest.rpartition(":")[2]
    right = {
        "unix": bool(rest),
        "file": bool(rest),
        "shm": rest.startswith("/") and len(rest) > 1 and "/" not in rest[1:],
        "udp": port.isdecimal() and 0 < int(port) < 65536,
    }
    if not right.get(kind, False):
        raise BadInput(f"{address}: {ALLOWED}")


def _file_of(address: str) -> pathlib.Path | None:
    """What the reader opens; None of a socket."""
    kind, _, rest = address.partition(":")
    return {"shm": pathlib.Path(f"/dev/shm{rest}"), "file": pathlib.Path(rest)}.get(kind)


def open_address(address: str, apid_first: int) -> Bus:
    """@errors BadInput: what is wrong with the address in one line."""
    check_address(address)
    try:
        return open_bus(address, apid_first)
    except FileNotFoundError:
        wanted = "no such ring; a run makes it (transport.send)" if address.startswith("shm:") else "no such file or folder"
        raise BadInput(f"{address}: {wanted}") from None
    except (OSError, ValueError) as problem:
        said = getattr(problem, "strerror", None) or str(problem)
        busy = "; another reader has it: shm: serves several" if "in use" in said else ""
        raise BadInput(f"{address}: {said.removeprefix(f'{address} ').removeprefix(f'{address}: ')}{busy}") from None


class Feed:
    """Reads until it is closed. A ring or file that another one has replaced is opened again."""

    def __init__(self, address: str, apid_first: int):
        self._address, self._apid_first = address, apid_first
        self._bus = open_address(address, apid_first)
        self._opened = self._identity()
        self._state, self._lock, self._ended = State(), threading.Lock(), threading.Event()
        self.problem = ""  # why it can't go on
        self._thread = threading.Thread(target=self._read, name="packets", daemon=True)
        self._thread.start()

    def snapshot(self) -> State:
        with self._lock:
            return self._state.snapshot()

    def _identity(self) -> tuple[int, int] | None:
        file = _file_of(self._address)
        with contextlib.suppress(OSError):
            if file is not None:
                status = os.stat(file)
                return status.st_dev, status.st_ino
        return None

    def _open_again(self) -> None:
        now = self._identity()
        if now is None or now == self._opened:
            return
        with contextlib.suppress(BadInput):  # not whole as yet
            bus = open_address(self._address, self._apid_first)
            self._bus.close()
            self._bus, self._opened = bus, now

    def _read(self) -> None:
        try:
            while not self._ended.is_set():
                octets = self._bus.next_octets(WAIT_S)
                packet = None if octets is None else decode(octets, self._apid_first)
                with self._lock:
                    if packet is not None:
                        self._state.take(packet)
                    self._state.missing, self._state.damaged_octets = self._bus.missing, self._bus.damaged
                if octets is None:
                    self._open_again()
        except OSError as problem:
            self.problem = f"{self._address}: {problem.strerror or problem}"

    def close(self) -> None:
        self._ended.set()
        self._thread.join(5 * WAIT_S)
        with contextlib.suppress(OSError):  # its path may have been removed
            self._bus.close()


def silence_s(state: State) -> float:
    """Since the last packet; infinite before the first."""
    return time.monotonic() - state.arrived_s if state.arrived_s else float("inf")
