"""A video by PyAV: true presentation times, turned as its rotation flag says, damage counted."""

import bisect
import pathlib
import statistics
from collections.abc import Iterator

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.capture_rate import slowed_by, tell_mode
from polhode_ground.importing.decoding import frame_levels
from polhode_ground.importing.joined import check_is_one
from polhode_ground.importing.multipart import PartTimes, times_of_parts
from polhode_ground.importing.packets import Decoder, complaint, heard
from polhode_ground.importing.ser import times_of_ser
from polhode_ground.importing.shown import aspect_of, first_field, mirrored, upright
from polhode_ground.importing.source import EDITED_OUT, NS, Account, Frame, Options, Source

ROLLING = "a rolling shutter is not undone: state line_time_ns in sensor.yaml, from one row to the next"
MISSING = "missing in the file, whose header promises them"
SER = "ser"
MULTIPART = ("mpjpeg", "mjpeg")
EMPTY = "an empty place in the file: the recorder dropped it"
ANY_CAMERA = Options().camera
NO_NAMES = ("", "und", "VideoHandler")  # what FFmpeg writes where nobody named a track
# Decoders that complain where a frame is missing that others are built on.
TELL_GAPS = ("h264", "hevc")
# A file of pictures without compression, Y4M: one that is cut has a beginning, and no number of frames.
BARE_PICTURES, BARE_HEAD = "yuv4mpegpipe", b"FRAME\n"
# After so many errors of the container in a row the rest is given up.
ERRORS_IN_A_ROW = 20


def open_video(path: pathlib.Path, options: Options) -> Source:
    import av
    import av.logging

    account, logs = Account(), []
    try:
        with heard(av.logging.ERROR) as logs, av.open(str(path)) as container:
            stream = chosen_stream(container, path, account, options.camera)
            if container.format.name == "image2" or container.format.name.endswith("_pipe"):  # FFmpeg's readers of pictures
                raise BadInput(f"{path}: found a single picture")
            check_is_one(path, container.format.name)
            parts = times_of_parts(path, options, account) if container.format.name in MULTIPART else None
            rate_hz, nominal = rate_of(path, container, stream, options, account, parts)
            slowed = 1.0 if rate_hz else slowed_by(path, container, stream, account)
            tell_mode(container, account)
            number = stream.index
            words = f"video, {stream.codec_context.name}, {stream.width}x{stream.height}"
    except (av.FFmpegError, OSError) as problem:
        raise BadInput(f"{path}: not a video that can be read ({_reason(path, problem, logs)})") from None
    account.assumed.append(ROLLING)
    clock = read_clock(path, number, rate_hz, account, slowed, parts)
    times_ns, lost = clock.all_ns()
    rate = rate_hz or slowed * _rate_of(times_ns)
    words += f", {rate:.4g} frames/s" if rate else ""
    return Source(
        words,
        _frames(path, number, account, clock),
        account,
        count=len(times_ns) - len(lost),
        nominal_time=nominal,
        times_ns=times_ns,
        lost=lost,
    )


def _rate_of(times_ns: list[int | None]) -> float:
    """By the times that are taken: what a header says of it may be anything. 0 of a single frame."""
    known = sorted(time for time in times_ns if time is not None)
    step_ns = statistics.median([after - before for before, after in zip(known, known[1:])] or [0])
    return NS / step_ns if step_ns else 0.0


def _reason(path: pathlib.Path, problem, logs: list[tuple[int, str, str]]) -> str:
    if not any("moov atom not found" in text for _, _, text in logs):
        return problem.strerror or str(problem)
    with open(path, "rb") as file:
        box = file.read(8)[4:]
    if box in (b"ftyp", b"mdat", b"wide", b"free", b"skip"):  # the first of a real one (ISO 14496-12, QuickTime)
        return (
            "its index, the box moov, is missing: the recording was not closed, or the file is cut or damaged at its end or its beginning"
        )
    return "its content is not what its name says"


def chosen_stream(container, path: pathlib.Path, account: Account, camera: str = ANY_CAMERA):
    """The largest video, or that with the number, title or language that `camera` says; a cover picture is none.

    @errors BadInput where there are several, and none is called so
    """
    import av

    streams = [one for one in container.streams.video if not one.disposition & av.stream.Disposition.attached_pic]
    if not streams:
        raise BadInput(f"{path}: a media file without a video stream")
    best = max(streams, key=lambda one: one.width * one.height)  # the first of equals
    if len(streams) == 1:
        return best
    found = ", ".join(_words_of(number, one) for number, one in enumerate(streams))
    asked = [one for number, one in enumerate(streams) if camera.casefold() in _names_of(number, one)]
    if camera != ANY_CAMERA and len(asked) != 1:
        raise BadInput(
            f"{path}: {len(streams)} videos in one file: {found}; {len(asked)} of them are called '{camera}': --camera takes a number, a title or a language"
        )
    best = asked[0] if len(asked) == 1 else best
    number = streams.index(best)
    other = (number + 1) % len(streams)
    account.assumed.append(f"{len(streams)} videos in one file: {found}; number {number} is taken, --camera {other} takes number {other}")
    return best


def _names_of(number: int, stream) -> set[str]:
    numbers = {str(number), f"cam{number}"} - {ANY_CAMERA}
    return numbers | {text.casefold() for text in _tags_of(stream)}


def _tags_of(stream) -> list[str]:
    tags = (stream.metadata.get(name, "") for name in ("title", "handler_name", "language"))
    return list(dict.fromkeys(text for text in tags if text not in NO_NAMES))


def _words_of(number: int, stream) -> str:
    said = " ".join(_tags_of(stream))
    return f"number {number}, {stream.width}x{stream.height}{f' ({said})' if said else ''}"


def rate_of(
    path: pathlib.Path, container, stream, options: Options, account: Account, parts: PartTimes | None
) -> tuple[float | None, bool]:
    """(frames per second where the file tells no times, else None; whether that is made up)."""
    import av

    if parts:
        account.assumed.append(parts.said)
    if parts and parts.at:
        _tell_no_rate(options, account)
        return None, False
    if container.format.name == SER and times_of_ser(path) is not None:
        account.assumed.append("the times are those that the file has behind its pictures")
        return None, False
    if container.format.name != SER and not container.format.flags & av.format.Flags.no_timestamps.value:
        account.assumed.append("the time of a frame is its presentation time")
        _tell_no_rate(options, account)
        return None, False
    stated = 0.0 if container.format.name == SER else float(stream.codec_context.framerate or 0)  # FFmpeg's own guess
    rate_hz = options.rate_hz or stated or 1.0
    how = (
        "as --rate-hz says"
        if options.rate_hz
        else "as its header says"
        if stated
        else "so rates and velocity are per picture: give --rate-hz"
    )
    if options.rate_hz and stated and abs(options.rate_hz / stated - 1) > 0.01:
        how += f"; its header says {stated:g}"
    account.assumed.append(f"a bare {container.format.name} stream tells no times: {rate_hz:g} frames a second, {how}")
    return rate_hz, not (options.rate_hz or stated)


def _tell_no_rate(options: Options, account: Account) -> None:
    if options.rate_hz:
        account.assumed.append("--rate-hz is left out: the video tells its times")


class Packets:
    """Packets of a stream, to the end of the file whatever lies between; what the container complains of."""

    def __init__(self, container, stream, account: Account):
        self._container, self._stream, self._account = container, stream, account
        self.count, self.edited, self.end, self._complaints = 0, 0, 0, []

    def __iter__(self):
        """Of those with a picture in them. The decoder drops what an edit list leaves out."""
        errors, source = 0, self._container.demux(self._stream)
        while errors <= ERRORS_IN_A_ROW:
            try:
                packet = self._next(source)
            except StopIteration:
                break
            except Exception as problem:
                self._complain(getattr(problem, "strerror", None) or str(problem))
                errors, source = errors + 1, self._container.demux(self._stream)
                continue
            errors = 0
            if packet.size:
                self.count += 1
                self.end = (packet.pos or 0) + packet.size
                self.edited += packet.is_discard
                yield packet
        self._tell()

    def _next(self, source):
        import av.logging

        with heard(av.logging.ERROR) as logs:
            packet = next(source)
        said = complaint([entry for entry in logs if entry[1] != self._stream.codec_context.name])
        if said:
            self._complain(said)
        return packet

    def _complain(self, text: str) -> None:
        if text not in self._complaints:
            self._complaints.append(text)

    def _tell(self) -> None:
        if self._complaints:
            self._account.assumed.append(f"the container is damaged: {'; '.join(self._complaints[:3])}")
        if self.edited:
            self._account.dropped[EDITED_OUT] += self.edited


def read_clock(
    path: pathlib.Path, number: int, rate_hz: float | None, account: Account, slowed: float = 1.0, parts: PartTimes | None = None
) -> "Clock":
    """Reads all packets, and decodes none. @param number  of the stream in its container. @param slowed  by how much the video is slower than the world"""
    import av

    with av.open(str(path)) as container:
        stream = container.streams[number]
        packets = Packets(container, stream, account)
        clock = Clock(rate_hz, container.format.name == "avi", parts if parts and parts.at else None)
        for packet in packets:
            clock.add(packet)
        if container.format.name == SER and rate_hz is None:
            clock.shown_ns = (times_of_ser(path) or [])[: packets.count]
        clock.settle(account)
        clock.missing = missing_at_end(path, container, stream, packets, clock)
        if container.format.name == "avi":
            clock.find_empty()
        clock.shown_ns = [None if time is None else round(time / slowed) for time in clock.shown_ns] if slowed != 1 else clock.shown_ns
        clock.empty_ns = [round(time / slowed) for time in clock.empty_ns]
    return clock


def missing_at_end(path: pathlib.Path, container, stream, packets: Packets, clock: "Clock") -> int:
    """Frames that the file's index or its duration promise, and that are not in it."""
    read = packets.count
    if container.format.name == BARE_PICTURES:
        return int(path.stat().st_size - packets.end > len(BARE_HEAD))
    if container.format.name.startswith("mov"):  # an edit list leaves frames of stream.frames out
        entries = stream.index_entries
        return max(0, len(entries) - read) if any(one.pos + one.size > path.stat().st_size for one in entries) else 0
    if stream.frames:
        return max(0, stream.frames - read)
    if len(container.streams) > 1 or not container.duration or container.format.name in ("mpegts", "mpeg"):  # a guess of FFmpeg's
        return 0
    first_s, end_s = clock.span_s()
    rate = read / (end_s - first_s) if end_s > first_s else 0.0  # the header's may be another
    # Some containers' duration counts from 0, some from the first frame.
    short = min(abs(container.duration / 1e6 - end_s), abs(container.duration / 1e6 - (end_s - first_s))) * rate
    return round(short) if short > 1.5 and container.duration / 1e6 > end_s - first_s else 0


def _frames(path: pathlib.Path, number: int, account: Account, clock: "Clock") -> Iterator[Frame]:
    import av

    with av.open(str(path)) as container:
        stream = container.streams[number]
        decoder = Decoder(stream.codec_context, account)
        try:
            for place, packet in enumerate(Packets(container, stream, Account())):
                yield from _pictures(decoder.feed(packet, clock.shown_ns[place]), stream, clock, account)
            yield from _pictures(decoder.feed(None), stream, clock, account)
            if clock.missing:
                account.dropped[MISSING] += clock.missing
        finally:
            decoder.finish()
            gap_s = None if stream.codec_context.name in TELL_GAPS else clock.gap_s()
            if gap_s is not None:
                account.assumed.append(f"frames are missing before {gap_s:.3f} s: those to the next key frame may be damaged")


class Clock:
    """Times of frames. An AVI tells those of packets only: its n-th frame is shown at the n-th of them."""

    def __init__(self, rate_hz: float | None, by_place: bool, parts: PartTimes | None):
        """@param parts  times by the packets' places in the file, where it tells them so"""
        self.rate_hz, self.by_place, self.parts = rate_hz, by_place, parts
        self.shown_ns: list[int | None] = []  # of the packets
        self.keys: list[bool] = []
        self.dropped: list[bool] = []  # by an edit list
        self.begins: list[int] = [0]  # packets with which the container's clock begins again
        self._last_dts: int | None = None
        self.missing = 0  # frames that are promised, after the last packet
        self.empty_ns: list[int] = []  # places without a frame, between those of packets
        self._tick_ns = 0.0

    def add(self, packet) -> None:
        ticks = packet.dts if self.by_place else packet.pts
        self.keys.append(packet.is_keyframe)
        self.dropped.append(packet.is_discard)
        if packet.dts is not None:
            if self._last_dts is not None and packet.dts < self._last_dts:
                self.begins.append(len(self.shown_ns))
            self._last_dts = packet.dts
        if self.rate_hz or self.parts:
            self.shown_ns.append(self.parts.of(packet.pos) if self.parts else None)
        else:  # whole nanoseconds, without the rounding of float
            self.shown_ns.append(None if ticks is None else round(ticks * packet.time_base * NS))
            self._tick_ns = float(packet.time_base * NS)

    def settle(self, account: Account) -> None:
        """No time is before 0."""
        first_ns = min((time for time, out in zip(self.shown_ns, self.dropped) if time is not None and not out), default=0)
        if first_ns < 0:
            account.assumed.append(f"the first presentation time is {first_ns / NS:.6g} s: all are later by that")
            self.shown_ns = [None if time is None else time - first_ns for time in self.shown_ns]

    def time_ns(self, picture) -> int | None:
        if self.rate_hz:
            return round(picture.place * NS / self.rate_hz)
        return self.shown_ns[picture.place if self.by_place else picture.packet]

    def find_empty(self) -> None:
        """Of a container that numbers its places: those that it counts as frames, and that have none."""
        known = sorted(time for time in self.shown_ns if time is not None)
        empty = [
            round(before + self._tick_ns * number)
            for before, after in zip(known, known[1:])
            for number in range(1, min(round((after - before) / self._tick_ns), self.missing + 2))
        ]
        if len(empty) <= self.missing:
            self.empty_ns, self.missing = empty, self.missing - len(empty)

    def all_ns(self) -> tuple[list[int | None], dict[int, str]]:
        """(times of all frames in order of display, those too that are missing at the end; places without a frame, and why)."""
        count = self.dropped.count(False)
        if self.rate_hz:
            return [round(number * NS / self.rate_hz) for number in range(count)], {}
        known = []
        for begin, end in zip(self.begins, [*self.begins[1:], len(self.shown_ns)]):
            known += sorted(time for time, out in zip(self.shown_ns[begin:end], self.dropped[begin:end]) if time is not None and not out)
        if self.empty_ns:  # they lie between the others, in a container whose clock does not begin again
            known = sorted([*known, *self.empty_ns])
        lost = dict.fromkeys((bisect.bisect_left(known, time) for time in self.empty_ns), EMPTY)
        step_ns = (known[-1] - known[0]) / (len(known) - 1) if len(known) > 1 else NS
        times = known + [round(known[-1] + step_ns * number) for number in range(1, self.missing + 1)] if known else []
        return [None if place in lost else time for place, time in enumerate(times)], lost

    def span_s(self) -> tuple[float, float]:
        """First time, and the end of the last frame."""
        known = sorted(time for time in self.shown_ns if time is not None)
        return (known[0] / NS, (known[-1] + (known[-1] - known[0]) / max(len(known) - 1, 1)) / NS) if known else (0.0, 0.0)

    def gap_s(self) -> float | None:
        """Where the first frame after a gap of steady times is built on others, from the first on; None: nowhere."""
        times = np.array([np.nan if time is None else time for time in self.shown_ns], float)
        if np.isnan(times).any() or len(times) < 3:
            return None
        order = np.argsort(times)
        steps = np.diff(times[order])
        steady = np.median(steps)
        if np.mean(np.abs(steps - steady) < 0.2 * steady) <= 0.9:
            return None
        after = order[1:][steps > 1.5 * steady]
        return next(((times[number] - times.min()) / NS for number in after if not self.keys[number]), None)


def _pictures(pictures, stream, clock: Clock, account: Account) -> Iterator[Frame]:
    for picture in pictures:
        time_ns, frame = clock.time_ns(picture), picture.frame
        if time_ns is None:
            account.dropped["no presentation time"] += 1
            continue
        levels = frame_levels(frame)
        account.note(levels.remark)
        pixels = levels.pixels
        if frame.interlaced_frame:
            account.note("interlaced: the two fields are of different times; the second is left out, its lines are interpolated")
            pixels = first_field(pixels)
        yield Frame(
            time_ns,
            pixels=mirrored(upright(pixels, frame.rotation, account), frame, account),
            bits=levels.bits,
            pixel_aspect=aspect_of(stream, frame.rotation),
        )
