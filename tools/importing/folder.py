"""A folder of pictures: times from EXIF, from names that are nanoseconds or seconds, else by a rate."""

import pathlib
import re
from collections.abc import Iterator

from importing.pictures import exif_lens, exif_time_ns, in_folder
from importing.source import NS, Account, Frame, Options, Source

from judge.errors import BadInput

# A name of 16 digits and more is taken for nanoseconds since 1970 or since start, as EuRoC and ROS tools write them.
NANOSECONDS_DIGITS = 16
SECONDS = re.compile(r"\d{9,10}\.\d{3,9}")  # as TUM's tools name pictures


def open_folder(path: pathlib.Path, options: Options) -> Source:
    files = in_folder(path)
    if not files:
        raise BadInput(f"{path}: no pictures in it; expected are a folder of pictures, a sequence, a COLMAP project or a bag")
    account = Account()
    times_ns, nominal, said = times_of(files, options.rate_hz)
    account.assumed.append(said)
    found = exif_lens(files[0])
    lens, lens_from = found if found else (None, "")
    return Source(f"folder of {len(files)} pictures", _frames(files, times_ns), account, len(files), lens, lens_from, nominal)


def times_of(files: list[pathlib.Path], rate_hz: float | None) -> tuple[list[int], bool, str]:
    """(times, whether they are made up, where they are from in words)."""
    if rate_hz is None:
        names = [_time_of_name(path.stem) for path in files]
        if all(time is not None for time in names) and len(set(names)) == len(names):
            return names, False, "times are those in the pictures' names"
        taken = [exif_time_ns(path) for path in files]
        if all(time is not None for time in taken) and all(b > a for a, b in zip(taken, taken[1:])):
            return taken, False, "times are EXIF's; they tell when the shutter was pressed, not the middle of the exposure"
        rate_hz, why = 1.0, "EXIF's times repeat or run back" if any(taken) else "the pictures tell no time"
        said = f"{why}: one picture a second is assumed, so rates and velocity are per picture; give --rate-hz"
        return _steady(len(files), rate_hz), True, said
    return _steady(len(files), rate_hz), False, f"pictures are {1 / rate_hz:g} s apart, as --rate-hz says"


def _steady(count: int, rate_hz: float) -> list[int]:
    return [round(index * NS / rate_hz) for index in range(count)]


def _time_of_name(stem: str) -> int | None:
    if stem.isdigit() and len(stem) >= NANOSECONDS_DIGITS and int(stem) < 2**63:
        return int(stem)
    if SECONDS.fullmatch(stem):
        whole, fraction = stem.split(".")
        return int(whole) * NS + int(fraction.ljust(9, "0"))
    return None


def _frames(files: list[pathlib.Path], times_ns: list[int]) -> Iterator[Frame]:
    for file, time_ns in sorted(zip(files, times_ns), key=lambda pair: pair[1]):
        yield Frame(time_ns, file=file)
