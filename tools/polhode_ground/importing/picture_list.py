"""Lists of pictures with times, by their columns' names or by what is in them: EuRoC's, TUM's, associated ones, those of spreadsheets."""

import datetime
import pathlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

from polhode_ground.common.delimited import rows_of, separator_of, text_of
from polhode_ground.common.errors import BadInput
from polhode_ground.common.units import SINCE_1970_NS, UNITS, WORDS, doubt, likely_units, median_step
from polhode_ground.importing.source import NS, PICTURES, Account

TIME_NAME = re.compile(r"\W*(time|stamp|t\b|t_)", re.IGNORECASE)
FILE_NAME = re.compile(r"file|image|picture|frame|name|path|img", re.IGNORECASE)
UNIT = r"(?P<count>10*|0\.\d+)?\s?(?P<scale>n|u|µ|μ|m|nano|micro|milli)?(?:s|secs?|seconds?)\b"
IN_BRACKETS, UNIT_IN_BRACKETS, UNIT_AT_END = (
    re.compile(r"([\[(])\s*(.*?)\s*[\])]"),
    re.compile(UNIT, re.IGNORECASE),
    re.compile("[_ ]" + UNIT, re.IGNORECASE),
)
UNIT_OF_SCALE = {"": "s", "n": "ns", "nano": "ns", "u": "us", "µ": "us", "μ": "us", "micro": "us", "m": "ms", "milli": "ms"}
# Square brackets hold a unit, or a scale of time; others hold anything.
NO_UNIT = re.compile(r"|.*(:|yy|\b(utc|gps|tai|unix|epoch|posix|iso.?\d*|local|date|time|stamp|from|since|of)\b).*", re.IGNORECASE)
OTHER_UNIT = re.compile(r".*[\d/].*|(ticks?|counts?|cycles?|clocks?|jiffies|samples?|min|minutes?|h|hours?|days?)", re.IGNORECASE)
COUNT_BY_NAME = re.compile(r"_(ticks?|cycles?|jiffies)\b", re.IGNORECASE)
ALLOWED = "[s], [ms], [us], [ns] and counts of them, as [100ns]"
# Counts of 100 ns begin in the year 1 (.NET) or 1601 (Windows' FILETIME): 1970 in ns.
TICKS_BEGIN_NS = {1601: 11_644_473_600 * NS, 1: 62_135_596_800 * NS}
DATE = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:\.(\d+))?(Z|[+-]\d\d:\d\d)?")
DAY, CLOCK = re.compile(r"\d{4}-\d\d-\d\d"), re.compile(r"\d\d:\d\d:\d\d.*")
# What stands where times do, and is none, nor a column's name.
BAD_STAMP = re.compile(r"[-+]?\.?\d.*|[-+]?(nan|inf|infinity)", re.IGNORECASE)
NO_LIGHT = re.compile(r"depth|disparity|mask|label", re.IGNORECASE)
ADVICE = "--stamp-unit s, ms, us or ns says which"


@dataclass
class PictureList:
    """Rows of (time as it is written, name), and the unit that the list's head tells, or ''; also one that is not known."""

    rows: list[tuple[Decimal, str]]
    unit: str = ""


def has_columns(path: pathlib.Path) -> bool:
    """Whether a table's head names a time and a file."""
    try:
        _, names = _table(path)
    except BadInput:
        return False
    return any(map(TIME_NAME.match, names)) and any(map(FILE_NAME.search, names))


def read_times(path: pathlib.Path, files: list[pathlib.Path], needs_names: bool = False) -> tuple[list[Decimal], str, bool]:
    """(times, their unit or '', whether they are in the order of these files, whose names the list holds; else in that of the list).
    @errors BadInput where it holds no times, or not those of all files by their names where these are needed"""
    rows, names = _table(path)
    of_time = [name for name in names if TIME_NAME.match(name)]
    if needs_names and len(of_time) > 1:
        raise BadInput(f"{path}: {' and '.join(of_time)} may both be the times: a file times.csv with one of these columns tells which")
    place, of_name = _columns(rows, names)
    if of_name is not None:
        times = {
            pathlib.PurePath(name).name: time
            for time, name in (_row(path, number, cells, place, of_name, "a time") for number, cells in rows)
        }
        if all(file.name in times for file in files):
            return [times[file.name] for file in files], _unit(names, place), True
    if needs_names:
        missing = [file.name for file in files if of_name is None or file.name not in times]
        raise BadInput(f"{path}: it does not list {len(missing)} of the {len(files)} pictures, as {missing[0]}")
    if place == 0 and len(rows[0][1]) > 1 and not TIME_NAME.match((names or [""])[0]) and _counts(rows):
        place = 1  # DSO's: number, time, exposure
    return [_row(path, number, cells, place, None, "a time")[0] for number, cells in rows], _unit(names, place), False


def _counts(rows: list[tuple[int, list[str]]]) -> bool:
    """Whether the first column is the number of the row."""
    first = rows[0][1][0]
    return (
        first.isdecimal()
        and all(cells[0] == f"{int(first) + place:0{len(first)}d}" for place, (_, cells) in enumerate(rows))
        and _is_number(rows[0][1][1])
    )


def read_list(path: pathlib.Path, wanted: str) -> PictureList:
    """@param wanted  what a row should be, for messages. @errors BadInput with the line"""
    rows, names = _table(path)
    place, of_name = _columns(rows, names)
    return PictureList([_row(path, number, cells, place, of_name, wanted) for number, cells in rows], _unit(names, place))


def _table(path: pathlib.Path) -> tuple[list[tuple[int, list[str]]], list[str]]:
    """(rows with their lines' numbers, the columns' names as far as they are told)."""
    text = text_of(path, "surrogateescape")
    separator = separator_of(text)
    table = [(number, _with_dates(cells)) for number, cells in rows_of(text, separator)]
    head = next((cells for _, cells in table if not cells[0].startswith("#")), [])
    has_head = bool(head) and not _is_row(head)
    heads = [line.lstrip("# ") for line in text.splitlines() if line.lstrip().startswith("#")]
    remarks = [cells for _, cells in rows_of("\n".join(map(_unit_beside, heads) if separator == " " else heads), separator)]
    names = head if has_head else remarks[-1] if remarks else []
    rows = [(number, cells) for number, cells in table if not cells[0].startswith("#")][has_head:]
    if not rows:
        raise BadInput(f"{path}: lists no pictures")
    rows = [(number, _with_blanks(cells, path.parent) if separator == " " else cells) for number, cells in rows]
    _check_decimal_commas(path, names, rows, separator)
    return rows, names


def _unit_beside(head: str) -> str:
    """A head whose units stand without a blank beside the names, as cells are told apart by blanks."""
    return re.sub(r"\s*([\[(].*?[\])])", lambda found: re.sub(r"\s+", "-", re.sub(r"(?<=\d)\s+", "", found[1])), head)


def _with_dates(cells: list[str]) -> list[str]:
    """A date and a clock with a blank between them are one time."""
    place = next((place for place, (day, clock) in enumerate(zip(cells, cells[1:])) if DAY.fullmatch(day) and CLOCK.fullmatch(clock)), None)
    return cells if place is None else [*cells[:place], " ".join(cells[place : place + 2]), *cells[place + 2 :]]


def _is_row(cells: list[str]) -> bool:
    """Not the names of columns: also a row whose time is none, which must be told and not passed over."""
    return any(_is_number(cell) or _is_picture(cell) or BAD_STAMP.fullmatch(cell) for cell in cells) or not any(
        map(str.isalpha, "".join(cells))
    )


def _is_number(cell: str) -> bool:
    return _number(cell) is not None


def _number(cell: str) -> Decimal | None:
    """A number, or the seconds since 1970 of a date with a clock, taken for UTC where it names no zone."""
    try:
        return Decimal(cell) if Decimal(cell).is_finite() else None
    except InvalidOperation:
        return _seconds_of_date(cell)


def _seconds_of_date(cell: str) -> Decimal | None:
    found = DATE.fullmatch(cell)
    if not found:
        return None
    try:
        when = datetime.datetime.fromisoformat(f"{found[1]}T{found[2]}{(found[4] or 'Z').replace('Z', '+00:00')}")
    except ValueError:
        return None
    return Decimal(int(when.timestamp())) + Decimal(f"0.{found[3] or 0}")


def _with_blanks(cells: list[str], folder: pathlib.Path) -> list[str]:
    """A name may hold white space."""
    rest = " ".join(cells[1:])
    return [cells[0], rest] if len(cells) > 2 and (folder / rest).is_file() else cells


def _check_decimal_commas(path: pathlib.Path, names: list[str], rows: list[tuple[int, list[str]]], separator: str) -> None:
    number, cells = rows[0]
    parts = [row[1] for _, row in rows if len(row) == 2]
    if (
        separator == ","
        and not names
        and len(parts) == len(rows) > 1
        and all(map(str.isdecimal, [*cells, *parts]))
        and len(set(map(len, parts))) == 1
        and any(part.startswith("0") for part in parts)
    ):
        raise BadInput(f"{path}:{number}: '{','.join(cells)}' looks like a number with a decimal comma: write a point")
    if (
        separator == ","
        and len(names) > 1
        and all(len(row) == len(names) + 1 for _, row in rows)
        and all(cell.isdecimal() for cell in cells[:2])
    ):
        raise BadInput(
            f"{path}:{number}: {len(cells)} cells where the head has {len(names)}, as with a decimal comma: "
            "write a point, or separate the cells by semicolons"
        )


def _is_picture(cell: str) -> bool:
    return pathlib.PurePath(cell).suffix.lower() in PICTURES


def _columns(rows: list[tuple[int, list[str]]], names: list[str]) -> tuple[int, int | None]:
    """Places of the time and of the name; None: the time is the name."""
    cells = rows[0][1]
    pictures = [place for place, cell in enumerate(cells) if _is_picture(cell)]
    of_light = [place for place in pictures if not NO_LIGHT.search(cells[place])]
    of_name = next(iter(of_light or pictures), None)
    numbers = [place for place, cell in enumerate(cells) if _is_number(cell) and place != of_name]
    named = [place for place in numbers if place < len(names) and TIME_NAME.match(names[place])]
    before = [place for place in numbers if of_name is not None and place < of_name]
    # Associated lists have a time before each name.
    place = before[-1] if len(pictures) > 1 and before else (named or before[-1:] or numbers or [0])[0]
    if of_name is None and len(cells) > 1 and cells[1] and not _is_number(cells[1]):
        of_name = 1
    return place, of_name


def _row(path: pathlib.Path, number: int, cells: list[str], place: int, of_name: int | None, wanted: str) -> tuple[Decimal, str]:
    if place >= len(cells) or not _is_number(cells[place]) or of_name is not None and of_name >= len(cells):
        raise BadInput(f"{path}:{number}: '{' '.join(cells)}' is not {wanted}")
    return _number(cells[place]), cells[of_name] if of_name is not None and cells[of_name] else f"{cells[place]}.png"


def _unit(names: list[str], place: int) -> str:
    """One of judge.units, with a count before it where the column has one; as it is written where it is another."""
    name = names[place] if place < len(names) else ""
    brackets = IN_BRACKETS.search(name)
    found = UNIT_IN_BRACKETS.match(brackets[2]) if brackets else UNIT_AT_END.search(name)
    if found:
        count = found["count"] or ""
        return f"{count if count != '1' else ''}{UNIT_OF_SCALE[(found['scale'] or '').lower()]}"
    if brackets:
        return brackets[2] if OTHER_UNIT.fullmatch(brackets[2]) or brackets[1] == "[" and not NO_UNIT.fullmatch(brackets[2]) else ""
    by_name = COUNT_BY_NAME.search(name)
    return by_name[1] if by_name else ""


def _counted(values: Sequence, stated: str, where: str, account: Account) -> tuple[Sequence, str]:
    """Values in a unit of judge.units, of a head that tells so many of one. @errors BadInput of a unit that is not known"""
    count = re.fullmatch(r"([\d.]+)(s|ms|us|ns)", stated)
    if not count and stated not in UNITS:
        raise BadInput(f"{where}: the head says that its times are in '{stated}', allowed are {ALLOWED}; {ADVICE}")
    if not count:
        return values, stated
    times = [Decimal(value) * Decimal(count[1]) for value in values]
    for year, begin in TICKS_BEGIN_NS.items():
        since_1970 = [time - Decimal(begin) * UNITS["ns"] / UNITS[count[2]] for time in times]
        if SINCE_1970_NS[0] <= since_1970[0] * UNITS[count[2]] < SINCE_1970_NS[1]:
            account.assumed.append(f"the times count {stated} since the year {year}: they are taken since 1970")
            return since_1970, count[2]
    return times, count[2]


def in_ns(values: Sequence, stated: str, asked: str | None, where: str, account: Account, rate_hz: float | None = None) -> list[int]:
    """@param asked  the unit that the user says. @param rate_hz  of the frames, where the values are their numbers.
    @errors BadInput where the stated unit can't be, and which it is is not clear"""
    values, stated = (values, asked) if asked else _counted(values, stated, where, account)
    are_counts = _count_frames(values)
    if are_counts and rate_hz and not asked:
        account.assumed.append(
            f"the list has numbers of frames in place of times: {1 / rate_hz:g} s from one to the next, as --rate-hz says"
        )
        return [round(value * NS / Decimal(rate_hz)) for value in map(Decimal, values)]
    if rate_hz:
        account.assumed.append("--rate-hz is left out: the list tells its times")
    units = [asked] if asked else likely_units(values, stated)
    counted = f"if they are numbers of frames, --rate-hz{' without --stamp-unit' if asked else ''} says how many there are a second"
    advice = f"{ADVICE}; {counted}" if are_counts else ADVICE
    if len(units) != 1:
        likely = f"these look like {' or '.join(WORDS[unit] for unit in units)}" if units else "no unit of time fits them"
        raise BadInput(f"{where}: stamps that are no {WORDS[stated]}, so far apart are no pictures of a camera: {likely}; {advice}")
    unit = units[0]
    if unit != stated and not asked:
        account.assumed.append(
            f"the stamps can't be {WORDS[stated]}: they are taken for {WORDS[unit]}, as their steps are those of a camera; {advice}"
        )
    elif not asked and doubt(values, unit):
        account.assumed.append(f"{doubt(values, unit)}; if that is wrong, {advice}")
    elif are_counts:
        account.assumed.append(f"the times are whole {WORDS[unit]}, one after the other; {counted}")
    times = [int(value * UNITS[unit]) for value in values]
    if max(map(abs, times)) >= 2**63:
        raise BadInput(f"{where}: a stamp of {max(values)} {WORDS[unit]} is beyond what a sequence can hold; {ADVICE}")
    return times


def _count_frames(values: Sequence) -> bool:
    """Whether they may be numbers of frames: whole, one after the other, and of no clock."""
    return len(values) > 2 and all(value == int(value) and value < SINCE_1970_NS[0] // NS for value in values) and median_step(values) == 1
