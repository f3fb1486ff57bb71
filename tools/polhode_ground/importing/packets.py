"""Decodes a video packet by packet: damage costs the frames to the next key frame, not the rest, and what it costs is counted.

A frame is left out where the decoder complained of its packet, or of one between it and the key frame that it is built on.
"""

import bisect
import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field

from polhode_ground.importing.source import Account

# FFmpeg's words for reference pictures of H.264 that never came. They are told on the level of debugging only.
GAP = "Frame num gap"
# Told on the level of information: parts of a picture were made up.
CONCEALED = "concealing"
# Complaints of what is beside the picture: webcams' MJPEG, cameras' own messages, splices that were made with care.
HARMLESS = ("unable to decode APP fields", "SEI type", "Invalid SEI", "mmco: unref short failure")
DAMAGED = "damaged, or built on a damaged frame"
EARLY = "before the first key frame"
PLACES_NAMED = 3


@contextlib.contextmanager
def heard(level: int) -> Iterator[list[tuple[int, str, str]]]:
    """What FFmpeg says meanwhile, in all its threads, each time that it says it."""
    import av.logging

    av.logging.set_skip_repeated(False)
    av.logging.set_level(level)
    try:
        with av.logging.Capture(False) as logs:
            yield logs
    finally:
        av.logging.set_level(None)


def complaint(logs: list[tuple[int, str, str]]) -> str:
    """What FFmpeg says against a picture; empty where nothing."""
    import av.logging

    for level, name, text in logs:
        if (level <= av.logging.ERROR or text.startswith((GAP, CONCEALED))) and not text.startswith(HARMLESS):
            return f"{name}: {'earlier pictures are missing' if text.startswith(GAP) else ' '.join(text.split())}"
    return ""


@dataclass
class Damage:
    """Packets from `begin` on, in order of decoding, to the next key frame `end`. None: there is none."""

    begin: int
    why: str
    end: int | None = None
    frames: int = 0


@dataclass
class Picture:
    """A frame with the number of its packet, and its place in the order of display."""

    packet: int
    place: int
    frame: object


@dataclass
class Decoder:
    """`context` is FFmpeg's decoder, not yet used. Packets are numbered as they are fed."""

    context: object
    account: Account
    times_ns: list[int | None] = field(default_factory=list)  # when the packets' frames are shown
    damages: list[Damage] = field(default_factory=list)
    breaks: list[int] = field(default_factory=list)  # packets that the decoder complained of
    keys: list[int] = field(default_factory=lambda: [-1])  # packets of key frames that came out whole
    seen: set[int] = field(default_factory=set)  # packets whose frames came out
    place: int = 0
    ended: bool = False

    def __post_init__(self) -> None:
        # One thread: a complaint belongs to the packet at hand, and FFmpeg tells what it conceals with one alone.
        self.context.thread_count = 1
        if self.context.name == "h264":
            self.context.options = {"err_detect": "aggressive"}  # else slices that end early pass without a word

    def feed(self, packet, time_ns: int | None = None) -> Iterator[Picture]:
        """Whole pictures in order of display. @param packet  None: the stream has ended"""
        import av
        import av.logging

        frames, why, number, self.ended = [], "", len(self.times_ns), packet is None
        if packet is not None:
            packet.pts = packet.dts = number  # the decoder hands it on to the frame
            why = "the container marks the packet as damaged" if packet.is_corrupt else ""
            self.times_ns.append(time_ns)
            if packet.is_discard:  # by an edit list: the decoder keeps the frame
                self.seen.add(number)
        with heard(av.logging.DEBUG if self.context.name == "h264" else av.logging.INFO) as logs:
            try:
                frames = self.context.decode(packet)
            except av.FFmpegError as error:
                why = f"{self.context.name}: {error.strerror}"
            why = complaint(logs) or why
        if packet is not None and why:
            self._break(number, why)
        for frame in frames:
            picture = self._placed(frame)
            if self._whole(frame):
                yield picture

    def _placed(self, frame) -> Picture:
        if frame.key_frame and (self.damages or not self.seen):  # what never came out has its place, too
            self.place = max(self.place, frame.pts)
        self.place += 1
        return Picture(frame.pts, self.place - 1, frame)

    def _break(self, number: int, why: str) -> None:
        bisect.insort(self.breaks, number)
        if not self.damages or self.damages[-1].end is not None:
            self.damages.append(Damage(number, why))
        self.damages[-1].begin = min(self.damages[-1].begin, number)

    def _built_on_damage(self, number: int) -> bool:
        key = self.keys[bisect.bisect_right(self.keys, number) - 1]
        place = bisect.bisect_right(self.breaks, key)
        return place < len(self.breaks) and self.breaks[place] <= number

    def _whole(self, frame) -> bool:
        number = frame.pts
        if frame.is_corrupt:
            self._break(number, f"{self.context.name}: the picture is damaged")
        if frame.key_frame and number > self.keys[-1] and number not in self.breaks:
            self._resume(number)
        self.seen.add(number)
        if self._built_on_damage(number):
            self._count(number)
            return False
        return True

    def _resume(self, key: int) -> None:
        """Damaged frames shown before this key frame, but decoded after it, are references of none that follow."""
        self.keys.append(key)
        leading = [number for number in self.breaks if number > key and (number in self.seen or self._shown_before(number, key))]
        for number in leading:
            self.breaks.remove(number)
            if number not in self.seen:
                self.seen.add(number)
                self._count(number)
        if self.damages and self.damages[-1].end is None and key > self.damages[-1].begin:
            self.damages[-1].end = key

    def _shown_before(self, number: int, key: int) -> bool:
        times = self.times_ns[number], self.times_ns[key]
        return None not in times and times[0] < times[1]

    def _count(self, number: int) -> None:
        next((damage for damage in reversed(self.damages) if damage.begin <= number), self.damages[0]).frames += 1

    def finish(self) -> None:
        """Counts what never came out, and tells the places."""
        hidden = [number for number in range(len(self.times_ns)) if number not in self.seen]
        for number in hidden:
            if self._built_on_damage(number):
                self._count(number)
        first = min(self.seen, default=0)
        quiet = [number for number in hidden if not self._built_on_damage(number)]
        early = sum(number < first for number in quiet)
        if early:
            self.account.dropped[EARLY] += early
        if len(quiet) > early and self.ended:
            self.account.assumed.append(f"{len(quiet) - early} packets of the video hold no picture of their own")
        lost = sum(damage.frames for damage in self.damages)
        if lost:
            self.account.dropped[DAMAGED] += lost
        for damage in self.damages[:PLACES_NAMED]:
            to = "to the end: no key frame follows" if damage.end is None else f"to the next key frame{self._at(damage.end)}"
            self.account.assumed.append(f"damage{self._at(damage.begin)} ({damage.why}): {damage.frames} frames are left out, {to}")
        if len(self.damages) > PLACES_NAMED:
            self.account.assumed.append(f"damage at {len(self.damages) - PLACES_NAMED} more places")

    def _at(self, number: int) -> str:
        """In seconds from the stream's own start, as a player shows it."""
        if self.times_ns[number] is None:
            return f" at packet {number}"
        return f" at {(self.times_ns[number] - min(time for time in self.times_ns if time is not None)) * 1e-9:.3f} s"
