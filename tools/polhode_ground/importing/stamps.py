"""Time stamps of a source, judged all together before any frame is left out.

A camera's stamps lie on a line over the frames' numbers. A clock that is right never runs back, and frames that are lost
let it jump ahead for good. What leaves the line and comes back to it is one bad stamp; what leaves it for good by running
back is a counter that wrapped, or a clock that was set.
"""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass, field

from polhode_ground.common.units import is_impossible, median_step
from polhode_ground.importing.source import NS

OUT_OF_LINE = "time out of line with its neighbours'"
REPEATS = "time repeats that of the frame before"
NO_TIME = "tells no time"
CLOCK_SET = "not of the longest part between settings of the clock"

# Chosen: so many bad stamps in a row are still told from a clock that was set.
BAD_IN_A_ROW_MAX = 30
# Frames come no faster than their neighbours do: rates that drift by 5 %, and 0.4 of an interval for jitter.
RATE_DRIFT, JITTER = 0.05, 0.4
NEIGHBOURS = 10  # whose median interval is the rate at a place
# No recording of one target pauses for a year; a clock that is set for the first time jumps by decades.
PAUSE_MAX_NS = 365 * 24 * 3600 * NS
# Chosen: messages wait in queues for seconds, and not for longer than this.
RECEIPT_LATE_NS, RECEIPT_LATE_INTERVALS = 10 * NS, 20
# A single frame before or after such a pause (in intervals) is of no use to anybody, and its stamp is in doubt.
LONE_PAUSE = 100
UNIT_SAME = 0.1  # steps of stamps and of receipts
SHORT_LIST = 10  # in fewer stamps than this, no line is sure
# Counters: bits, and nanoseconds of a count. 8 ns is GigE Vision's usual tick, 90 kHz that of RTP and MPEG.
COUNTER_BITS = (16, 24, 32, 33, 40, 48)
COUNTER_TICKS_NS = (1, 8, 10, 100, 1_000, 10_000, 100_000, 1_000_000, NS / 90_000)
# Times of day and parts of times begin again at 0; FireWire's cycle timer does after 128 s.
CLOCK_PERIODS_NS = (NS, 60 * NS, 128 * NS, 3600 * NS, 86_400 * NS)
LOST_AT_ONCE = 30  # frames, beside bad stamps or where a counter wraps
WRAP_NEAR = 2.5  # intervals from the end of a clock's period, which are met by chance more easily
# Regular stamps: so many intervals are near the median. Only then can missing frames be counted.
REGULAR_SHARE, REGULAR_WIDTH = 0.8, 0.25
GAP = 1.75  # intervals of the median that are a gap
PAUSE = 10.0  # intervals of the median
BURSTS, BURST_MAX = 3, 30  # so many pauses, each after fewer frames than this: times of arrival


@dataclass
class Gaps:
    """What is missing between the stamps. Where they are irregular, frames can't be counted: then only the pauses are told."""

    interval_ns: float = 0.0  # the median
    frames: int = 0
    count: int = 0
    longest_s: float = 0.0
    after: int = 0  # place of the frame before the longest
    pauses: int = 0

    @property
    def said(self) -> str:
        """Empty where nothing is missing."""
        if self.pauses:
            return (
                f"{self.pauses} pauses of over {PAUSE:g} times the median interval of {self.interval_ns / NS:.6g} s, "
                f"the longest {self.longest_s:.6g} s: irregular times, frames can't be counted"
            )
        if not self.frames:
            return ""
        many = f"{self.count} gaps, the longest" if self.count > 1 else "a gap"
        doubt = " (or a pause, or a clock that was set ahead)" if self.longest_s > LONE_PAUSE * self.interval_ns / NS else ""
        return f"about {self.frames} frames in {many} of {self.longest_s:.6g} s after picture {self.after + 1} of the source{doubt}"


@dataclass
class Judgement:
    """times_ns[i] of the i-th stamp of the source, None where the frame is left out for the reason reasons[i]."""

    times_ns: list[int | None]
    reasons: dict[int, str] = field(default_factory=dict)
    assumed: list[str] = field(default_factory=list)
    wraps: list[str] = field(default_factory=list)  # counters that began again: a guess that moves all times after it


def judge(stamps: Sequence[int | None], received_ns: Sequence[int] | None = None) -> Judgement:
    """@param received_ns  when each frame was recorded, by another clock, where the source tells it"""
    judgement = Judgement(list(stamps))
    known = [stamp for stamp in stamps if stamp is not None]
    repeats = sum(a == b for a, b in zip(known, known[1:]))
    if received_ns is not None and len(known) > 1 and 2 * repeats >= len(known) - 1:
        what = f"header.stamp is {known[0]}" if len(set(known)) == 1 else "header.stamp repeats on half of the pictures"
        judgement.assumed.append(f"{what}: the times are when the bag received the messages")
        judgement.times_ns, received_ns = list(received_ns), None
    if received_ns is not None and None not in stamps and len(known) > 2:
        _judge_unit(judgement, received_ns)
    kept = _without_repeats(judgement)
    if len(kept) > 1:
        kept = _Line(judgement, received_ns).ordered(kept)
    _leave_out(judgement, set(kept), OUT_OF_LINE)
    _shift_to_zero(judgement, kept)
    return judgement


def _judge_unit(judgement: Judgement, received_ns: Sequence[int]) -> None:
    """Drivers that write microseconds where nanoseconds belong: the messages came a thousand times farther apart than they say."""
    step, received = median_step(judgement.times_ns), median_step(received_ns)
    factor = next((factor for factor in (10**3, 10**6, 10**9) if abs(received - factor * step) < UNIT_SAME * received), 0)
    if not factor or not is_impossible(step) or is_impossible(received):
        return
    first = judgement.times_ns[0]
    judgement.times_ns = [first + factor * (time - first) for time in judgement.times_ns]
    judgement.assumed.append(
        f"header.stamp is {step:.6g} ns from frame to frame, and the messages came {received / NS:.6g} s apart: the stamps' steps are "
        f"taken for a unit of {factor} ns"
    )


def _leave_out(judgement: Judgement, kept: set[int], reason: str) -> None:
    for place, time in enumerate(judgement.times_ns):
        if place not in kept:
            judgement.reasons.setdefault(place, NO_TIME if time is None else reason)
            judgement.times_ns[place] = None


def _without_repeats(judgement: Judgement) -> list[int]:
    kept = []
    for place, time in enumerate(judgement.times_ns):
        if time is None:
            continue
        if kept and judgement.times_ns[kept[-1]] == time:
            judgement.reasons[place] = REPEATS
            continue
        kept.append(place)
    return kept


class _Line:
    """The line through (place, stamp), and what leaves it."""

    def __init__(self, judgement: Judgement, received_ns: Sequence[int] | None) -> None:
        self.judgement, self.received_ns = judgement, received_ns
        self.times = judgement.times_ns

    def ordered(self, places: list[int]) -> list[int]:
        """The places that stay, in order of time."""
        self.interval = self._interval(places)
        self._judge_receipts(places)
        if self._is_a_list_out_of_order(places):
            is_backward = all(step < 0 for step in self._steps(places))
            self.judgement.assumed.append(
                "the list of pictures runs from the newest to the oldest: reversed"
                if is_backward
                else "the list of pictures is not in order of time: sorted"
            )
            places = sorted(places, key=self._time)
            repeats = {b for a, b in zip(places, places[1:]) if self._step(a, b) == 0}
            self.judgement.reasons |= dict.fromkeys(repeats, REPEATS)
            places = [place for place in places if place not in repeats]
            self.interval = self._interval(places)  # that of a list that ran back was of its few steps ahead, or of none
        return self._without_lone_ends(self._longest(self._parts(places)))

    def _time(self, place: int) -> int:
        return self.times[place]

    def _step(self, before: int, after: int) -> int:
        return self.times[after] - self.times[before]

    def _steps(self, places: list[int]) -> list[int]:
        return [self._step(a, b) for a, b in zip(places, places[1:])]

    def _interval(self, places: list[int]) -> float:
        """The median of the steps ahead; 0 where there is none."""
        return statistics.median([step for step in self._steps(places) if step > 0] or [0])

    def _judge_receipts(self, places: list[int]) -> None:
        """The recording may run at another speed than the stamps, as a simulation does."""
        if self.received_ns is None:
            return
        received = statistics.median([self.received_ns[b] - self.received_ns[a] for a, b in zip(places, places[1:])])
        self.speed = self.interval / received if received > 0 else 1.0

    def _is_a_list_out_of_order(self, places: list[int]) -> bool:
        """Lists that were shuffled or put together become a line by sorting, those of a clock that was set do not."""
        descents = sum(step < 0 for step in self._steps(places))
        if descents == 0 or 3 * descents > len(places):
            return descents > 0
        steps = self._steps(sorted(places, key=self._time))
        median = statistics.median(steps)
        return min(steps) > 0.6 * median and sum(step > 1.5 * median for step in steps) < descents

    def _parts(self, places: list[int]) -> list[list[int]]:
        """Places in parts, each of them a line without its bad stamps."""
        parts: list[list[int]] = []
        offset = 0  # of a counter that wrapped
        for run in self._runs(places):
            self._move(run, offset)
            if parts and self._is_attached(parts, run):
                continue
            period = self._wrapped_ns(parts[-1][-1], run[0], offset) if parts else 0
            if period:
                self._tell_wrap(period, parts[-1][-1])
                self._move(run, period)
                offset += period
                parts[-1] += run
            else:
                parts.append(run)
        return parts

    def _move(self, places: list[int], by_ns: int) -> None:
        for place in places if by_ns else ():
            self.times[place] += by_ns

    def _runs(self, places: list[int]) -> list[list[int]]:
        """Pieces in which the stamps rise, by no more than a recording pauses."""
        runs = [[places[0]]]
        for before, place in zip(places, places[1:]):
            if self._step(before, place) <= 0 or self._is_far(before, place):
                runs.append([])
            runs[-1].append(place)
        return runs

    def _is_far(self, before: int, after: int) -> bool:
        """Ahead by what no pause explains: by more than a year, or by more than the receipts allow."""
        step = self._step(before, after)
        if step > PAUSE_MAX_NS or self.received_ns is None:
            return step > PAUSE_MAX_NS
        received = self.speed * (self.received_ns[after] - self.received_ns[before])
        return step - 2 * received > max(RECEIPT_LATE_NS, RECEIPT_LATE_INTERVALS * self.interval)

    def _is_attached(self, parts: list[list[int]], run: list[int]) -> bool:
        """Puts the run behind the part that it goes on with; what stood between is left out."""
        for part in (parts[-1], max(parts, key=len)):
            removed = self._removed(part, run)
            if removed is not None:
                del part[len(part) - removed[0] :]
                part += run[removed[1] :]
                return True
        return False

    def _removed(self, part: list[int], run: list[int]) -> tuple[int, int] | None:
        """How many bad stamps to leave out at the part's end and at the run's start, the fewest; None where that mends nothing."""
        for both in range(BAD_IN_A_ROW_MAX + 1):
            for last in range(max(0, both - len(run) + 1), min(both, len(part) - 1) + 1):
                if self._goes_on(part, len(part) - 1 - last, run, both - last):
                    return last, both - last
        return None

    def _goes_on(self, part: list[int], end: int, run: list[int], start: int) -> bool:
        before, after = part[end], run[start]
        step = self._step(before, after)
        if step <= 0 or self._is_far(before, after):
            return False
        around = (part[max(0, end - NEIGHBOURS) : end + 1], run[start : start + NEIGHBOURS + 1])
        interval = min([self._interval(places) for places in around if len(places) > 2] or [self.interval])
        expected = (after - before) * interval
        is_late = after - before > 1 and step > 2 * expected + LOST_AT_ONCE * interval  # what is left out explains no pause
        return not is_late and step >= (1 - RATE_DRIFT) * expected - JITTER * interval

    def _wrapped_ns(self, last: int, first: int, offset: int) -> int:
        """The range of a counter that began again between two places; 0 where none did. @param offset  of earlier ranges"""
        before, after = self._time(last) - offset, self._time(first) - offset
        for period in (2**bits * tick for tick in COUNTER_TICKS_NS for bits in COUNTER_BITS):
            near = min(LOST_AT_ONCE * self.interval, 0.1 * period)
            at_its_end = 0 <= after < near and period - near < before <= period
            # An epoch that a driver adds moves both ends: then the step alone tells.
            if period > LOST_AT_ONCE * self.interval and (at_its_end or abs(before + self.interval - after - period) < 0.5 * self.interval):
                return round(period)
        for period in CLOCK_PERIODS_NS:
            near = min(WRAP_NEAR * self.interval, 0.4 * period)
            if 0 <= after < near and period - near < before < period:
                return period
        return 0

    def _tell_wrap(self, period: int, place: int) -> None:
        note = f"the stamps are those of a counter that begins again after {period / NS:.9g} s"
        if not any(one.startswith(note) for one in self.judgement.assumed):
            self.judgement.assumed.append(f"{note}, first after picture {place + 1} of the source: unwrapped")
            self.judgement.wraps.append(
                f"the stamps begin again after picture {place + 1} of the source, as a counter does after {period / NS:.9g} s"
            )

    def _longest(self, parts: list[list[int]]) -> list[int]:
        """The longest part; a short one is bad stamps, the others are told as those of a clock that was set."""
        longest = max(parts, key=len)
        short = max(3, sum(len(part) for part in parts) // 50)
        for part in parts:
            if part is not longest and len(part) > short:
                self.judgement.reasons |= dict.fromkeys(part, CLOCK_SET)
        long_ones = sorted(part for part in parts if len(part) > short)
        for before, part in zip(long_ones, long_ones[1:]):
            last = max(place for place in before if place < part[0])
            step_s = (self._step(last, part[0]) - (part[0] - last) * self.interval) / NS
            self.judgement.assumed.append(
                f"the clock was set {'ahead' if step_s > 0 else 'back'} by {abs(step_s):.6g} s before picture {part[0] + 1} of the "
                f"source: of {len(long_ones)} parts the longest is taken, of {len(longest)} pictures"
            )
        return longest

    def _without_lone_ends(self, places: list[int]) -> list[int]:
        pause = LONE_PAUSE * self.interval
        if len(places) >= SHORT_LIST and self._step(*places[:2]) > pause:
            places = places[1:]
        if len(places) >= SHORT_LIST and self._step(*places[-2:]) > pause:
            places = places[:-1]
        return places


def _shift_to_zero(judgement: Judgement, kept: list[int]) -> None:
    """`polhode replay` takes no times before 0."""
    first = min((judgement.times_ns[place] for place in kept), default=0)
    if first < 0:
        judgement.assumed.append(f"the times begin at {first / NS:.9g} s: all are shifted to begin at 0")
        for place in kept:
            judgement.times_ns[place] -= first


def find_gaps(times_ns: list[int | None], held: range) -> Gaps:
    """Between the frames that stay of these places. Frames that are left out for their stamps lie there too: they are told by themselves."""
    kept = sorted((place for place in held if times_ns[place] is not None), key=lambda place: times_ns[place])
    steps = [times_ns[b] - times_ns[a] for a, b in zip(kept, kept[1:])]
    if not steps:
        return Gaps()
    interval = statistics.median(steps)
    gaps = Gaps(interval_ns=interval)
    left_out = [b - a - 1 for a, b in zip(kept, kept[1:])] if kept == sorted(kept) else [0] * len(steps)
    pauses = sum(step > PAUSE * interval for step in steps)
    in_bursts = pauses >= BURSTS and pauses * BURST_MAX >= len(steps)
    is_regular = sum(abs(step - interval) <= REGULAR_WIDTH * interval for step in steps) >= REGULAR_SHARE * len(steps)
    if len(kept) < SHORT_LIST or in_bursts or not is_regular:
        gaps.pauses, gaps.longest_s = pauses, max(steps) / NS
        return gaps
    missing = [max(0, round(step / interval) - 1 - out) if step > GAP * interval else 0 for step, out in zip(steps, left_out)]
    if kept != sorted(kept):  # nobody knows where in time they belong: in the widest gaps
        for _ in range(sum(times_ns[place] is None for place in held)):
            widest = max(range(len(missing)), key=missing.__getitem__)
            missing[widest] = max(0, missing[widest] - 1)
    if any(missing):
        longest = max(range(len(steps)), key=lambda i: missing[i])
        gaps.frames, gaps.count, gaps.longest_s, gaps.after = (
            sum(missing),
            sum(one > 0 for one in missing),
            steps[longest] / NS,
            kept[longest],
        )
    return gaps
