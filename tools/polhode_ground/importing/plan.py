"""Which frames of a source are taken, at which times; and afterwards, what was lost of them."""

import pathlib
import statistics
from bisect import bisect
from collections import Counter, defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, replace

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.source import BEFORE_FROM, BY_STEP, CHOSEN_AWAY, NS, Frame, Source
from polhode_ground.importing.stamps import find_gaps, judge

NOT_DECODED = "in the source, but could not be decoded"
UNLISTED = "time is not among those that the source lists"
LOSS_TOLD, LOSS_REFUSED = 0.1, 0.5  # shares of the frames
# A decoder gives frames out of the order of the file by less than this (H.264: 16).
REORDERED_MAX = 64
HOLE = 1.5  # intervals between the frames beside one that did not come


@dataclass
class Loss:
    """What the source has, or seems to miss, and the sequence has not."""

    frames: int
    of: int
    seconds: float
    held_share: float  # lost of the frames that the source holds

    @property
    def is_refused(self) -> bool:
        return self.held_share >= LOSS_REFUSED

    @property
    def is_told(self) -> bool:
        return self.frames >= LOSS_TOLD * self.of

    @property
    def said(self) -> str:
        return f"{self.frames} of {self.of} frames ({100 * self.frames / self.of:.0f} %, about {self.seconds:.6g} s) are lost or missing"


@dataclass
class Part:
    """What of the source the user wants: from_s to to_s after the first frame, every step-th of them."""

    from_s: float = 0.0
    to_s: float | None = None
    step: int = 1
    unwrap: bool = False  # stamps are those of a counter that begins again


class Plan:
    """The frames that are taken, at times that rise."""

    def __init__(self, source: Source, part: Part) -> None:
        """@errors BadInput where a counter wrapped and nobody said that it may"""
        self.source, self.account = source, source.account
        self.judgement = judge(source.times_ns, source.received_ns)
        self.judgement.reasons |= source.lost
        if self.judgement.wraps and not part.unwrap:
            raise BadInput(f"{source.kind}: {self.judgement.wraps[0]}; --unwrap counts on from there")
        self.account.assumed += self.judgement.assumed
        if part.unwrap and not self.judgement.wraps and not source.unwrapped:
            self.account.assumed.append("--unwrap is left out: no counter wraps in these times")
        self.chosen = self._choose(part)
        self.ends_early = part.to_s is not None
        self.seen: set[int] = set()
        self.without_place = 0  # frames that the source counts as lost, at no time that it lists
        first, last = (min(self.chosen), max(self.chosen)) if self.chosen else (0, 0)
        held = range(first if part.from_s > 0 else 0, last + 1 if part.to_s is not None else len(source.times_ns))
        self.held = len(held)
        self.gaps = find_gaps(self.judgement.times_ns, held)
        bad = Counter(reason for place, reason in self.judgement.reasons.items() if place in held)
        self.bad_stamps = bad.total()
        self.account.dropped += bad

    def _choose(self, part: Part) -> dict[int, int]:
        """Time by place."""
        rows = sorted((time, place) for place, time in enumerate(self.judgement.times_ns) if time is not None)
        if not rows:
            return {}
        # Whole numbers: a float of nanoseconds since 1970 has steps of 256.
        begin, end = rows[0][0] + round(part.from_s * NS), rows[-1][0] if part.to_s is None else rows[0][0] + round(part.to_s * NS)
        inside = [(place, time) for time, place in rows if begin <= time <= end]
        chosen = dict(inside[:: part.step])
        early = sum(time < begin for time, _ in rows)
        self.account.dropped += Counter({BEFORE_FROM: early, BY_STEP: len(inside) - len(chosen)})
        return chosen

    def frames(self) -> Iterator[Frame]:
        places = defaultdict(deque)
        for place, time in enumerate(self.source.times_ns):
            places[time].append(place)
        last, delivered = max(self.chosen, default=-1), 0
        for frame in self._read():
            known = places[frame.timestamp_ns]
            if not known:
                self.account.dropped[UNLISTED] += 1
                continue
            place = known.popleft()
            delivered += 1
            if place in self.chosen:
                self.seen.add(place)
                yield replace(frame, timestamp_ns=self.chosen[place])
            # Without an end that was asked for it is read to its own: a reader tells there what is damaged or missing.
            if self.ends_early and (place > last + REORDERED_MAX or len(self.seen) == len(self.chosen)):
                break
        not_come = self._not_come()
        unseen = len(self.source.times_ns) - len(self.source.lost) - delivered  # also those that are left out for their stamps
        self.without_place = max(0, self.faults_told - max(not_come, unseen))
        not_told = not_come - self.told_by_source
        if not_told > 0:
            self.account.dropped[NOT_DECODED] += not_told

    def files_beside(self) -> tuple[pathlib.Path, ...]:
        """Those that still hold: not where stamps were moved."""
        files, names = self.source.beside, " and ".join(file.name for file in self.source.beside)
        moved = any(time is not None and time != own for time, own in zip(self.judgement.times_ns, self.source.times_ns))
        if files:
            self.account.assumed.append(
                f"{names} of the source {'is left out: its stamps are not those of the sequence' if moved else 'is copied'}"
            )
        return () if moved else files

    def _read(self) -> Iterator[Frame]:
        """The source's frames; counts what it drops itself."""
        self.told_by_source = self.faults_told = 0
        frames = iter(self.source.frames)
        while True:
            before, faults = self.account.dropped.total(), self._faults()
            frame = next(frames, None)
            self.told_by_source += self.account.dropped.total() - before
            self.faults_told += self._faults() - faults
            if frame is None:
                return
            yield frame

    def _faults(self) -> int:
        return sum(count for reason, count in self.account.dropped.items() if reason not in CHOSEN_AWAY)

    def _not_come(self) -> int:
        """Chosen places that leave a hole. Some codecs have packets that no frame is made of: these leave none."""
        seen = sorted(self.chosen[place] for place in self.seen)
        interval = statistics.median([b - a for a, b in zip(seen, seen[1:])] or [0])
        count = 0
        for place in self.chosen.keys() - self.seen:
            time = self.chosen[place]
            after = bisect(seen, time)
            if 0 < after < len(seen):
                count += seen[after] - seen[after - 1] > HOLE * interval
            else:  # beyond the ends: as far off as a frame would be
                count += not seen or min(abs(time - seen[0]), abs(time - seen[-1])) > HOLE / 2 * interval
        return count

    def loss(self) -> Loss:
        """After the last frame."""
        of = self.held + self.without_place
        kept = (1 - self.bad_stamps / max(1, of)) * (1 - (self._faults() - self.bad_stamps) / max(1, len(self.chosen) + self.without_place))
        between = max(0, self.gaps.frames - self.without_place)  # a frame that the source counts, without a time, leaves a gap where it was
        lost = round((1 - kept) * of) + between
        return Loss(lost, of + between, lost * self.gaps.interval_ns / NS, 1 - kept)
