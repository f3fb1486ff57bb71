"""Levels that are no 8 or 16 bit whole numbers, scaled to 16 bits: alike for all pictures of a source, by what is in them."""

import pathlib
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import FULL_BITS
from polhode_ground.importing.decoding import Decoded, read_picture
from polhode_ground.importing.pictures import may_be_copied, pages_in_copy
from polhode_ground.importing.source import Account, Frame

FULL = 65535
# What writers take for full scale: 1 for floats, else the largest level of a camera's bits.
FULL_SCALES = (1, 255, 1023, 4095, 16383, 65535)
OVERSHOOT = 1.05  # resampled pictures go a little beyond their full scale
# Floats far below a full scale have another one, as scenes of light without a limit do: the largest level is taken.
FLOAT_SHARE_MIN = 1 / 8
# Single hot or broken pixels must not make the rest black.
COMMON_PERCENT, HOT_FACTOR = 99.9, 8.0
# Noise about a subtracted black level is cut at 0; levels further below are from a type with a sign, and are moved.
NEGATIVE_SHARE_MAX = 0.02
SAMPLES_MAX = 100_000  # of a picture, for percentiles


def is_native(pixels: np.ndarray) -> bool:
    return pixels.dtype in (np.uint8, np.uint16)


@dataclass
class Seen:
    """What the pictures of one number type hold."""

    kind: np.dtype
    smallest: float = np.inf
    largest: float = -np.inf
    low: float = np.inf  # without single pixels
    common: float = -np.inf  # the brightest without single pixels

    def add(self, pixels: np.ndarray) -> None:
        values = pixels[np.isfinite(pixels)] if self.kind.kind == "f" else pixels.ravel()
        if not values.size:
            return
        self.smallest, self.largest = min(self.smallest, float(values.min())), max(self.largest, float(values.max()))
        some = values[:: max(1, values.size // SAMPLES_MAX)].astype(np.float64)
        self.low = min(self.low, float(np.percentile(some, 100 - COMMON_PERCENT)))
        above = some[some > some.min()]
        self.common = max(self.common, float(np.percentile(above, COMMON_PERCENT)) if above.size else float(some[0]))


@dataclass
class Scale:
    """16-bit level = (level - zero) / full * 65535."""

    zero: float
    full: float
    seen: Seen
    cut: int = 0  # pixels beyond full scale
    negative: int = 0
    not_finite: int = 0
    pixels: int = 0

    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        levels = (pixels.astype(np.float64) - self.zero) * (FULL / self.full)
        unknown = np.isnan(levels)
        self.pixels += levels.size
        self.not_finite += int(np.count_nonzero(~np.isfinite(levels)))
        self.negative += int(np.count_nonzero(levels < -0.5))
        self.cut += int(np.count_nonzero(levels > FULL + 0.5))
        levels[unknown] = 0
        return np.rint(np.clip(levels, 0, FULL)).astype(np.uint16)

    def words(self) -> str:
        found = f"{self.seen.kind.name} levels, found {self.seen.smallest:.6g} to {self.seen.largest:.6g}"
        text = f"{found}: scaled to 16 bits, {self.zero:.6g} became 0 and {self.zero + self.full:.6g} became {FULL}"
        lost = (
            (self.cut, "beyond were cut"),
            (self.negative, "below were set to 0"),
            (self.not_finite, "not finite (NaN is 0, infinite is cut)"),
        )
        parts = [f"{100 * count / self.pixels:.2g} % of the pixels {what}" for count, what in lost if count]
        return ", ".join([text, *parts])


def full_scale(largest: float, whole_numbers: bool) -> float:
    if largest <= 0:
        return 1.0
    scales = FULL_SCALES[1:] if whole_numbers else FULL_SCALES
    full = next((scale for scale in scales if largest <= (scale if whole_numbers else OVERSHOOT * scale)), None)
    if whole_numbers:
        return float(full or 2 ** int(largest).bit_length() - 1)
    return float(full) if full and largest > FLOAT_SHARE_MIN * full else largest


def scale_of(seen: Seen) -> Scale:
    if seen.largest < seen.smallest:
        return Scale(0.0, 1.0, seen)  # nothing that is finite
    moved = seen.low < -NEGATIVE_SHARE_MAX * max(seen.common, 0.0)
    zero = seen.low if moved else 0.0
    hot = seen.largest - zero > HOT_FACTOR * (seen.common - zero) > 0
    return Scale(zero, full_scale((seen.common if hot else seen.largest) - zero, seen.kind.kind != "f"), seen)


@dataclass
class _Kept:
    """A frame that waits until the levels of all have been seen: its pixels are in its file, or at a place on disk."""

    frame: Frame  # without pixels
    place: pathlib.Path | None
    kind: np.dtype | None  # None: as it is

    def pixels(self) -> np.ndarray:
        return np.load(self.place) if self.place is not None else read_picture(self.frame.file).pixels


@dataclass
class Levels:
    """Turns the frames of a source into ones of 8 or 16 bits; files that the replay reads stay as they are."""

    account: Account
    seen: dict[np.dtype, Seen] = field(default_factory=dict)
    frames: int = 0
    remarks: Counter = field(default_factory=Counter)  # of pictures, what was done to them
    pages_beyond: int = 0  # the first, of files that have several

    def of(self, frames: Iterator[Frame]) -> Iterator[Frame]:
        frames = map(self._with_pixels, frames)
        try:
            yield from self._scaled(frames)
        finally:  # also where the last are not asked for
            self._tell()

    def _scaled(self, frames: Iterator[Frame]) -> Iterator[Frame]:
        for frame in frames:
            if frame.pixels is not None and not is_native(frame.pixels):
                yield from self._when_all_are_seen(chain([frame], frames))
                break
            yield frame

    def _tell(self) -> None:
        for remark, count in self.remarks.items():
            self.account.note(remark if count == self.frames else remark and f"{remark} (of {count} of {self.frames} pictures)")
        if self.pages_beyond:
            self.account.note(f"{self.pages_beyond} further pages of files are left out: a file of a folder is one frame")

    def _with_pixels(self, frame: Frame) -> Frame:
        """Without pixels where the file may be copied, or can't be read."""
        self.frames += 1
        if frame.pixels is not None:
            return frame
        try:
            if may_be_copied(frame.file):
                self.pages_beyond += pages_in_copy(frame.file) - 1
                return frame
            decoded = read_picture(frame.file)
        except BadInput as problem:
            return replace(frame, problem=str(problem))
        self._note(decoded)
        return replace(frame, pixels=decoded.pixels, bits=decoded.bits)

    def _note(self, decoded: Decoded) -> None:
        self.pages_beyond += decoded.pages - 1
        self.remarks[decoded.remark] += bool(decoded.remark)

    def _when_all_are_seen(self, frames: Iterator[Frame]) -> Iterator[Frame]:
        with tempfile.TemporaryDirectory(prefix="polhode_levels_") as folder:
            kept = [self._keep(frame, pathlib.Path(folder) / f"{index}.npy") for index, frame in enumerate(frames)]
            scales = {kind: scale_of(seen) for kind, seen in self.seen.items()}
            for one in kept:
                if one.kind is not None:
                    yield replace(one.frame, pixels=scales[one.kind](one.pixels()), bits=FULL_BITS)
                else:
                    yield one.frame if one.place is None else replace(one.frame, pixels=one.pixels())
            self.account.assumed.extend(scale.words() for scale in scales.values())

    def _keep(self, frame: Frame, place: pathlib.Path) -> _Kept:
        if frame.pixels is None:
            return _Kept(frame, None, None)
        native, kind = is_native(frame.pixels), frame.pixels.dtype.newbyteorder("=")
        if not native:
            self.seen.setdefault(kind, Seen(kind)).add(frame.pixels)
        if frame.file is None or native:
            np.save(place, frame.pixels)
            return _Kept(replace(frame, pixels=None), place, None if native else kind)
        return _Kept(replace(frame, pixels=None), None, kind)
