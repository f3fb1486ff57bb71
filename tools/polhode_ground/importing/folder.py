"""A folder of pictures: times from EXIF, from names that hold them, else by a rate and the numbers in the names."""

import datetime
import pathlib
import re
from collections.abc import Iterator

from polhode_ground.common.errors import BadInput
from polhode_ground.common.units import SINCE_1970_NS, UNITS, WORDS, is_impossible, median_step
from polhode_ground.importing import fits
from polhode_ground.importing.formats import kind_of_file
from polhode_ground.importing.numbering import (
    BEGINS_AGAIN,
    DATE_AND_CLOCK,
    decimals_of,
    frame_numbers,
    in_order,
    numbers_of,
    parts_of_seconds,
)
from polhode_ground.importing.outsiders import of_the_series
from polhode_ground.importing.pictures import exif_lens, exif_time_ns, in_folder, is_broken
from polhode_ground.importing.series import of_one_camera
from polhode_ground.importing.source import BROKEN_LINK, NS, Account, Frame, Options, Source, lens_if_any
from polhode_ground.importing.times_beside import times_beside

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
    if all(map(is_broken, files)):
        raise BadInput(
            f"{path}: {'only links to files that are not there' if files else 'no pictures'} in it; expected are a folder of pictures, a sequence, a COLMAP project or a bag"
        )
    files = of_the_series(of_one_camera(files, options.camera, account), options.camera, account)
    files, ordered_by = in_order(files)
    account.assumed += ordered_by
    times_ns, nominal = _times(path, files, options, account)
    # The first may be damaged, or by another tool than the others.
    lens, lens_from = lens_if_any(lambda: next(filter(None, map(exif_lens, files[:EXIF_TRIES])), (None, "")), account)
    lost = {place: BROKEN_LINK for place, file in enumerate(files) if is_broken(file)}
    times_ns = [None if place in lost else time for place, time in enumerate(times_ns)]
    count = len(files) - len(lost)
    return Source(
        f"folder of {count} pictures",
        frames_of(files, times_ns),
        account,
        times_ns,
        count,
        lens,
        lens_from,
        nominal,
        lost=lost,
        unwrapped=any(text.startswith(BEGINS_AGAIN) for text in ordered_by),
    )


def _times(path: pathlib.Path, files: list[pathlib.Path], options: Options, account: Account) -> tuple[list[int | None], bool]:
    """(times, whether they are made up)."""
    times_ns, nominal, said = times_of(files, options.rate_hz)
    beside = times_beside(path, files, options, account) if nominal else None
    if beside:
        return beside, False
    numbers = numbers_of([file.name for file in files]) if nominal and options.stamp_unit else None
    if numbers and not is_impossible(median_step(numbers) * UNITS[options.stamp_unit]):
        account.assumed.append(f"times are the numbers in the pictures' names, {WORDS[options.stamp_unit]}, as --stamp-unit says")
        return [int(number * UNITS[options.stamp_unit]) for number in numbers], False
    account.assumed += said
    if options.stamp_unit:
        account.assumed.append("--stamp-unit is left out: it is for lists and for numbers in names, and these times are of none")
    return times_ns, nominal


def times_of(
    files: list[pathlib.Path], rate_hz: float | None, root: pathlib.Path | None = None
) -> tuple[list[int | None], bool, list[str]]:
    """(times, None of a file that tells none where nearly all others do; whether they are made up; where they are from in words).

    @param root  of files in several folders
    """
    relative = [str(path.relative_to(root or path.parent)) for path in files]
    if rate_hz is not None:
        times_ns, said = _steady(relative, rate_hz)
        return times_ns, False, [f"pictures are {1 / rate_hz:g} s apart, as --rate-hz says", *said]
    told = []
    for what, said, read in TIME_TELLERS:
        times = read(files)
        if _tell([time for path, time in zip(files, times) if not is_broken(path)]):
            return times, False, [said]
        told += [what] if any(time is not None for time in times) else []
    why = f"{' and '.join(told)} repeat, run back or are missing" if told else "the pictures tell no time"
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


def _each(read):
    """Of files, by what is read of one."""
    return lambda files: list(map(read, files))


def _times_of_names(files: list[pathlib.Path]) -> list[int | None]:
    stems = [file.stem for file in files]
    seconds = decimals_of(stems)
    if seconds and all(SINCE_1970_NS[0] <= second * NS < SINCE_1970_NS[1] for second in seconds):
        return [int(second * NS) for second in seconds]
    alike = [stem for stem in stems if SECONDS.fullmatch(stem)]
    unpadded = alike if decimals_of(alike) is None else ()
    return [None if stem in unpadded else _time_of_name(stem) for stem in stems]


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


def _clocks_of_names(files: list[pathlib.Path]) -> list[int | None]:
    stems = [file.stem for file in files]
    parts = parts_of_seconds(stems) or [""] * len(files)
    return [None if time is None else time + int(part.ljust(9, "0") or 0) for time, part in zip(map(_clock_of_name, stems), parts)]


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


# (what tells times, what is said of them, the times of files or None), the best first.
TIME_TELLERS = (
    ("the times in the pictures' names", "times are those in the pictures' names", _times_of_names),
    (
        "the times of FITS' DATE-OBS",
        "times are FITS' DATE-OBS: when the exposures began",
        _each(lambda path: fits.time_ns(path) if kind_of_file(path) == "fits" else None),
    ),
    ("EXIF's times", "times are EXIF's; they tell when the shutter was pressed, not the middle of the exposure", _each(exif_time_ns)),
    ("the clocks in the pictures' names", "times are the dates and clocks in the pictures' names, taken for UTC", _clocks_of_names),
)


def frames_of(files: list[pathlib.Path], times_ns: list[int | None]) -> Iterator[Frame]:
    for file, time_ns in zip(files, times_ns):
        if time_ns is not None:
            yield Frame(time_ns, file=file)
