"""What every source of pictures gives: frames one by one, a lens where it knows one, and an account of what was done."""

import pathlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from importing.lens import Lens

NS = 1_000_000_000
# What `polhode replay` reads. Other pictures are decoded and written as PNG.
READ_BY_REPLAY = (".png", ".jpg", ".jpeg", ".pgm")
# What Pillow opens beside these and people have.
PICTURES = (*READ_BY_REPLAY, ".tif", ".tiff", ".bmp", ".webp", ".ppm")


@dataclass
class Options:
    """What the user may say of any source; each source uses what it understands."""

    rate_hz: float | None = None  # for pictures without a time
    topic: str | None = None  # bags
    camera: str = "cam0"  # EuRoC and Kalibr: which of several cameras


@dataclass
class Frame:
    """One picture: a file that may be copied as it is, or pixels [H,W] uint8 or uint16."""

    timestamp_ns: int
    file: pathlib.Path | None = None
    pixels: np.ndarray | None = None


@dataclass
class Account:
    """What was assumed, and how often frames were dropped for which reason."""

    assumed: list[str] = field(default_factory=list)
    dropped: Counter = field(default_factory=Counter)


@dataclass
class Source:
    """An open source. `frames` fills the account's `dropped` while it is read."""

    kind: str  # in words
    frames: Iterator[Frame]
    account: Account
    count: int | None = None  # of frames that are expected, for the progress; None: not known
    lens: Lens | None = None
    lens_from: str = ""
    nominal_time: bool = False  # the times are made up: rates per second mean nothing


def rising(frames: Iterator[Frame], account: Account) -> Iterator[Frame]:
    """Leaves out frames whose time does not rise, as `polhode replay` needs it."""
    last_ns = -1
    for frame in frames:
        if frame.timestamp_ns <= last_ns:
            account.dropped["time not after the frame before"] += 1
            continue
        last_ns = frame.timestamp_ns
        yield frame


def cropped(frames: Iterator[Frame], account: Account, from_s: float, to_s: float | None, step: int) -> Iterator[Frame]:
    """Frames from_s to to_s after the first, every step-th of them."""
    first_ns, number = None, 0
    for frame in frames:
        first_ns = frame.timestamp_ns if first_ns is None else first_ns
        after_s = (frame.timestamp_ns - first_ns) / NS
        if to_s is not None and after_s > to_s:
            return
        if after_s < from_s:
            account.dropped["before --from"] += 1
            continue
        number += 1
        if (number - 1) % step:
            account.dropped["by --step"] += 1
            continue
        yield frame
