"""A folder of pictures: times from EXIF, from names that hold them, else by a rate and the numbers in the names."""

import datetime
import pathlib
import re
from collections.abc import Iterator

from importing import fits
from importing.formats import kind_of_file
from importing.numbering import DATE_AND_CLOCK, frame_numbers, in_order
from importing.outsiders import of_the_series
from importing.pictures import exif_lens, exif_time_ns, in_folder
from importing.series import of_one_camera
from importing.source import NS, Account, Frame, Options, Source, lens_if_any
from importing.times_beside import times_beside

from judge.errors import BadInput

# A name of 16 digits is taken for microseconds since 1970, of more for nanoseconds since then or since start, as EuRoC and ROS tools write them.
MICROSECONDS_DIGITS = 16
# Where so many pictures tell a time, the others are left out.
TELLING_SHARE = 0.9
EXIF_TRIES = 10  # pictures that are asked for the focal length
SECONDS = re.compile(r"\d{9,10}\.\d{3,9}")  # as TUM's tools name pictures
# Numbers since 1970 of the years 2001 to 2065: milliseconds, microseconds, nanoseconds; seconds and a part of one.
SINCE_1970 = re.compile(r"(?<!\d)([12]\d{12}(?:\d{3}(?:\d{3})?)?)(?!\d)")
SECONDS_AND_PART = re.compile(r"(?<!\d)([12]\d{9})[-_.](\d{9}|\d{6})(?!\d)")


def open_folder(path: pathlib.Path, options: Options) -> Source:
    account = Account()
    files = in_folder(path, account)
    if not files:
        raise BadInput(f"{path}: no pictures in it; expected are a folder of pictures, a sequence, a COLMAP project or a bag")
    files = of_the_series(of_one_camera(files, options.camera, account), options.camera, account)
    files, ordered_by = in_order(files)
    account.assumed += ordered_by
    times_ns, nominal, said = times_of(files, options.rate_hz)
    beside = times_beside(path, files, options, account) if nominal else None
    times_ns, nominal, said = (beside, False, []) if beside else (times_ns, nominal, said)
    account.assumed += said
    if options.stamp_unit and not beside:
        account.assumed.append("--stamp-unit is left out: it is for lists, and these times are of none")
    # The first may be damaged, or by another tool than the others.
    lens, lens_from = lens_if_any(lambda: next(filter(None, map(exif_lens, files[:EXIF_TRIES])), (None, "")), account)
    return Source(f"folder of {len(files)} pictures", frames_of(files, times_ns), account, times_ns, len(files), lens, lens_from, nominal)


def times_of(files: list[pathlib.Path], rate_hz: float | None, root: pathlib.Path | None = None) -> tuple[list[int | None], bool, list[str]]:
    """(times, None of a file that tells none where nearly all others do; whether they are made up; where they are from in words).

    @param root  of files in several folders
    """
    relative = [str(path.relative_to(root or path.parent)) for path in files]
    if rate_hz is not None:
        times_ns, said = _steady(relative, rate_hz)
        return times_ns, False, [f"pictures are {1 / rate_hz:g} s apart, as --rate-hz says", *said]
    names = [_time_of_name(path.stem) for path in files]
    if _tell(names):
        return names, False, ["times are those in the pictures' names"]
    observed = [fits.time_ns(path) if kind_of_file(path) == "fits" else None for path in files]
    if _tell(observed):
        return observed, False, ["times are FITS' DATE-OBS: when the exposures began"]
    taken = [exif_time_ns(path) for path in files]
    if _tell(taken):
        return taken, False, ["times are EXIF's; they tell when the shutter was pressed, not the middle of the exposure"]
    clocks = [_clock_of_name(path.stem) for path in files]
    if _tell(clocks):
        return clocks, False, ["times are the dates and clocks in the pictures' names, taken for UTC"]
    why = "EXIF's times repeat, run back or are missing" if any(taken) else "the pictures tell no time"
    times_ns, said = _steady(relative, 1.0)
    return times_ns, True, [f"{why}: one picture a second is assumed, so rates and velocity are per picture; give --rate-hz", *said]


def _tell(times: list[int | None]) -> bool:
    """Whether nearly all of them are times that rise."""
    known = [time for time in times if time is not None]
    rising = [b > a for a, b in zip(known, known[1:])]
    return bool(known) and len(known) >= TELLING_SHARE * len(times) and sum(rising) >= TELLING_SHARE * len(rising)


def _steady(names: list[str], rate_hz: float) -> tuple[list[int], list[str]]:
    numbers, said = frame_numbers(names)
    return [round(number * NS / rate_hz) for number in numbers], [said] if said else []


def _time_of_name(stem: str) -> int | None:
    if stem.isdecimal() and len(stem) == MICROSECONDS_DIGITS:
        return 1000 * int(stem)
    if stem.isdecimal() and len(stem) > MICROSECONDS_DIGITS and int(stem) < 2**63:
        return int(stem)
    if SECONDS.fullmatch(stem):
        whole, fraction = stem.split(".")
        return int(whole) * NS + int(fraction.ljust(9, "0"))
    return _time_within(stem)


def _time_within(stem: str) -> int | None:
    """A time since 1970 beside other words, or in two parts: cam0_1403636579763555584, 1403636579_763555584, and 1403636579763 in milliseconds."""
    found = SECONDS_AND_PART.search(stem)
    if found:
        return int(found.group(1)) * NS + int(found.group(2).ljust(9, "0"))
    times = [int(number) * 10 ** (19 - len(number)) for number in SINCE_1970.findall(stem)]
    return times[0] if len(times) == 1 and times[0] < 2**63 else None


def _clock_of_name(stem: str) -> int | None:
    found = DATE_AND_CLOCK.search(stem)
    if found is None:
        return None
    *fields, fraction = found.groups()
    try:
        when = datetime.datetime(*map(int, fields), tzinfo=datetime.UTC)
    except ValueError:
        return None
    return int(when.timestamp()) * NS + int((fraction or "0").ljust(9, "0"))


def frames_of(files: list[pathlib.Path], times_ns: list[int | None]) -> Iterator[Frame]:
    for file, time_ns in zip(files, times_ns):
        if time_ns is not None:
            yield Frame(time_ns, file=file)
