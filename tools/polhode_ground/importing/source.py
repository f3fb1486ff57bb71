"""What every source of pictures gives: frames one by one, a lens where it knows one, and an account of what was done."""

import pathlib
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.lens import Lens

NS = 1_000_000_000
# Files of these names are pictures even where their content is damaged.
PICTURES = (
    ".png",
    ".jpg",
    ".jpeg",
    ".pgm",
    ".tif",
    ".tiff",
    ".bmp",
    ".webp",
    ".ppm",
    ".avif",
    ".heic",
    ".heif",
    ".jp2",
    ".exr",
    ".dpx",
    ".dng",
    ".fits",
    ".fit",
    ".fts",
)
VIDEOS = (".mp4", ".mov", ".avi", ".mkv", ".mts", ".m2ts", ".ts", ".webm", ".wmv", ".flv", ".mpg", ".m4v", ".3gp", ".insv", ".360")
# Left out on purpose: no loss.
BEFORE_FROM, BY_STEP, OTHER_CAMERA = "before --from", "by --step", "taken by another camera"
RECORDED_TWICE = "recorded twice: the same picture with the same stamp"
EDITED_OUT = "left out by the video's edit list"
OTHER_SERIES, COPIES = "of another series, by their names", "copies of pictures that are there"
CHOSEN_AWAY = (BEFORE_FROM, BY_STEP, OTHER_CAMERA, RECORDED_TWICE, EDITED_OUT, OTHER_SERIES, COPIES)
BROKEN_LINK = "a link to a file that is not there"


@dataclass
class Options:
    """What the user may say of any source; each source uses what it understands."""

    rate_hz: float | None = None  # for pictures without a time
    topic: str | None = None  # bags
    camera: str = "cam0"  # which of several: of EuRoC and Kalibr, a bag's frame_id, a word in the names of pictures
    stamp_unit: str | None = None  # of lists: s, ms, us or ns


@dataclass
class Frame:
    """One picture: a file, or pixels [H,W] of any number type (importing/levels.py makes them uint8 or uint16).

    Its time is one of the source's times_ns.
    """

    timestamp_ns: int
    file: pathlib.Path | None = None
    pixels: np.ndarray | None = None
    bits: int = 0  # that 16-bit levels are known to use; 0: not known
    problem: str = ""  # why the file can't be read
    pixel_aspect: float = 1.0  # width by height of what a pixel shows, as the container tells it; of pixels only


@dataclass
class Account:
    """What was assumed, and how often frames were dropped for which reason."""

    assumed: list[str] = field(default_factory=list)
    dropped: Counter = field(default_factory=Counter)
    no_lens: str = ""  # why the source's own lens can't be used

    def note(self, sentence: str) -> None:
        """Says it once, of however many frames it holds."""
        if sentence and sentence not in self.assumed:
            self.assumed.append(sentence)


@dataclass
class Source:
    """An open source. `frames` fills the account's `dropped` while it is read."""

    kind: str  # in words
    frames: Iterator[Frame]
    account: Account
    times_ns: list[int | None]  # of all its frames in its own order, as found: they are judged together before frames are read
    count: int | None = None  # of frames that are expected, for the progress; None: not known
    lens: Lens | None = None
    lens_from: str = ""
    nominal_time: bool = False  # the times are made up: rates per second mean nothing
    line_time_ns: float = 0.0  # from one row to the next, where the source's own sensor.yaml tells it
    received_ns: list[int] | None = None  # when each frame was recorded, by another clock
    unwrapped: bool = False  # a counter in the pictures' names began again, and was counted on
    lost: dict[int, str] = field(
        default_factory=dict
    )  # places whose frames are known to be lost before any is read, and why; their times are None
    beside: tuple[pathlib.Path, ...] = ()  # files that hold for the pictures at these times: a truth, a model


def lens_if_any(read: Callable[[], tuple[Lens | None, str]], account: Account) -> tuple[Lens | None, str]:
    """What read() gives. One that can't be used only matters where the user gives no other."""
    try:
        return read()
    except BadInput as problem:
        account.no_lens = str(problem)
        return None, ""
