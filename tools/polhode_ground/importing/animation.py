"""An animated WebP or AVIF by Pillow: FFmpeg takes it for a single picture."""

import pathlib
from collections.abc import Iterator

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.formats import kind_of_file
from polhode_ground.importing.source import Account, Frame, Options, Source

KINDS = ("webp", "avif")


def is_animation(path: pathlib.Path) -> bool:
    from PIL import Image

    if kind_of_file(path) not in KINDS:
        return False
    try:
        with Image.open(path) as picture:
            return getattr(picture, "n_frames", 1) > 1
    except OSError:
        return False


def open_animation(path: pathlib.Path, options: Options) -> Source:
    account, times_ns, time_ms = Account(), [], 0
    for duration_ms, _ in _shown(path, account):
        times_ns.append(time_ms * 1_000_000)
        time_ms += duration_ms
    account.assumed.append("the time of a frame is the sum of the durations before it")
    if not time_ms:
        raise BadInput(f"{path}: an animation whose frames have no duration; write its frames into a folder and give --rate-hz")
    kind = f"animation of {len(times_ns)} frames"
    return Source(kind, _frames(path, times_ns), account, count=len(times_ns), times_ns=times_ns)


def _shown(path: pathlib.Path, account: Account) -> Iterator[tuple[int, np.ndarray]]:
    """(duration [ms], pixels) of each frame."""
    from PIL import Image

    with Image.open(path) as picture:
        for index in range(picture.n_frames):
            try:
                picture.seek(index)
                pixels = np.asarray(picture.convert("L"))
            except (OSError, EOFError):
                account.dropped["missing in the file, whose header promises them"] += picture.n_frames - index
                return
            yield round(picture.info.get("duration", 0)), pixels


def _frames(path: pathlib.Path, times_ns: list[int]) -> Iterator[Frame]:
    for time_ns, (_, pixels) in zip(times_ns, _shown(path, Account())):
        yield Frame(time_ns, pixels=pixels)
