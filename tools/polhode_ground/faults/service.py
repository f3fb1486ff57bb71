"""One start of the program under a parent that does what a service manager does: listens for progress, ends what hangs."""

import dataclasses
import os
import pathlib
import signal
import socket
import subprocess
import time

from polhode_bus import open_bus

START_S = 120.0  # until it is ready
LIMIT_S = 600.0  # a start that still tells of progress then is in a loop
POLL_S = 0.001


@dataclasses.dataclass
class Start:
    """What came of it."""

    begun: str  # warm or cold, and why, in the program's words
    end: str  # "status N", "signal NAME", "watchdog" or "no end"
    last_words: str
    packets: list

    @property
    def warm(self) -> bool:
        return self.begun.startswith("start warm")

    @property
    def failed(self) -> bool:
        """A service manager would start it again."""
        return self.end != "status 0"

    @property
    def poses_valid(self) -> list[bool]:
        """Of each frame that was answered."""
        return [packet.pose_valid for packet in self.packets if packet.name == "motion"]


class _Progress:
    """The socket that the program tells of its progress."""

    def __init__(self, watchdog_s: float):
        self._watchdog_s, self._ready = watchdog_s, False
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(f"\0polhode-bit-flips-{os.getpid()}-{time.monotonic_ns()}")
        self._socket.setblocking(False)
        self._last_s = time.monotonic()

    def environment(self) -> dict[str, str]:
        name = self._socket.getsockname().decode().replace("\0", "@")
        return {**os.environ, "NOTIFY_SOCKET": name, "WATCHDOG_USEC": str(int(self._watchdog_s * 1e6))}

    def hangs(self) -> bool:
        try:
            while True:
                told = self._socket.recv(4096)
                if b"WATCHDOG=1" in told or b"READY=1" in told:
                    self._ready, self._last_s = True, time.monotonic()
        except BlockingIOError:
            return time.monotonic() - self._last_s > (self._watchdog_s if self._ready else START_S)

    def close(self) -> None:
        self._socket.close()


def _new_packets(bus_file: pathlib.Path, bus: list) -> list:
    if not bus and bus_file.exists():
        bus.append(open_bus(f"file:{bus_file}"))
    return list(bus[0].packets()) if bus else []


def _end(process: subprocess.Popen, progress: _Progress, begun_s: float) -> str | None:
    """None while it runs as it should."""
    status = process.poll()
    if status is not None:
        return f"status {status}" if status >= 0 else f"signal {signal.Signals(-status).name}"
    hangs = progress.hangs()
    if not hangs and time.monotonic() - begun_s < LIMIT_S:
        return None
    process.send_signal(signal.SIGABRT)
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()
    return "watchdog" if hangs else "no end"


def run(command: list, folder: pathlib.Path, watchdog_s: float, on_frames=None) -> Start:
    """@param watchdog_s  without progress for so long it is ended.
    @param folder  of this start alone; the program is to write its packets to `bus.ccsds` in it.
    @param on_frames  called with the process and the number of answered frames; True: not called again."""
    folder.mkdir()
    said = folder / "stderr.txt"
    progress, bus, packets, frames = _Progress(watchdog_s), [], [], 0
    begun_s = time.monotonic()
    try:
        with open(said, "w") as stderr:
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr, env=progress.environment())
        try:
            while (end := _end(process, progress, begun_s)) is None:
                new = _new_packets(folder / "bus.ccsds", bus)
                packets += new
                frames += sum(packet.name == "motion" for packet in new)
                if on_frames and on_frames(process, frames):
                    on_frames = None
                time.sleep(POLL_S)
        finally:
            process.kill()
            process.wait()
        packets += _new_packets(folder / "bus.ccsds", bus)
    finally:
        progress.close()
        for one in bus:
            one.close()
    lines = said.read_text(errors="replace").splitlines()
    begun = next((line for line in lines if line.startswith("start ")), "")
    return Start(begun, end, "".join(lines[-1:]), packets)
