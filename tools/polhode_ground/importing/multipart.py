"""A recorded HTTP stream of JPEGs, as IP cameras send it (multipart/x-mixed-replace): times in the headers of its parts, which FFmpeg does not read."""

import bisect
import email.utils
import functools
import mmap
import pathlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.picture_list import in_ns
from polhode_ground.importing.source import Account, Options

HEAD_MAX = 4096  # octets of a part's header
BEGIN_MAX = 4096  # within which the first boundary stands; the server's own header may stand before it
PART = re.compile(rb"(?:^|\r?\n)(--[^\s:]{1,200}[^\r\n]{0,100})\r?\n((?:[\w-]+:[^\r\n]*\r?\n)+)\r?\n")
FIELD = re.compile(rb"^([\w-]+):[ \t]*([^\r\n]*?)[ \t]*\r?$", re.MULTILINE)
STAMP = re.compile(r".*(time-?stamp|unix-?time)", re.IGNORECASE)
DATE = "date"


@dataclass(frozen=True)
class PartTimes:
    """Time [ns] by the place where a part's picture begins; empty where they can't be used, and why in `said`."""

    at: dict[int, int]
    said: str

    def of(self, place: int | None) -> int | None:
        """Of a packet there: of the part that it begins, or that follows what FFmpeg takes for its beginning."""
        after = bisect.bisect_left(self._begins, place or 0)
        return self.at[self._begins[after]] if after < len(self._begins) else None

    @functools.cached_property
    def _begins(self) -> list[int]:
        return list(self.at)


def times_of_parts(path: pathlib.Path, options: Options, account: Account) -> PartTimes | None:
    """None of a file that is no such stream, or whose parts tell no time."""
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as octets:
        parts = list(_parts(octets))
    name = _name_of_times([fields for _, fields in parts])
    if not name:
        return None
    told = [fields.get(name) for _, fields in parts]
    where = f"{name.title()} in the headers of its parts"
    values = [_value(text) if text is not None else None for text in told]
    missing = sum(value is None for value in values)
    if missing:
        return PartTimes({}, f"{where} is not read: {missing} of {len(parts)} have none that is a time")
    if any(b <= a for a, b in zip(values, values[1:])):
        return PartTimes({}, f"{where} is not read: it repeats or runs back{', as whole seconds do' if name == DATE else ''}")
    try:
        times = in_ns(values, "s", options.stamp_unit, f"{path}: {name.title()}", account)
    except BadInput as problem:
        return PartTimes({}, f"{where} is not read: {str(problem).removeprefix(f'{path}: ')}")
    return PartTimes(dict(zip((begin for begin, _ in parts), times)), f"the times are those of {where}, which the server wrote")


def _parts(octets) -> Iterator[tuple[int, dict[str, str]]]:
    """(where the picture begins, fields by their small names) of each part."""
    first = PART.search(octets[: BEGIN_MAX + HEAD_MAX])
    if first is None or b"image/jpeg" not in first[2].lower():
        return
    boundary, found = first[1], first
    begin = 0  # of what was searched
    while found:
        body = begin + found.end()
        fields = {name.decode().lower(): value.decode(errors="replace") for name, value in FIELD.findall(found[2])}
        if "image/" in fields.get("content-type", ""):
            yield body, fields
        length = fields.get("content-length", "")
        begin = octets.find(boundary, body + int(length) if length.isdecimal() else body)
        found = PART.match(octets[begin : begin + HEAD_MAX]) if begin >= 0 else None


def _name_of_times(parts: list[dict[str, str]]) -> str:
    """The field that most parts have; one of fractions of seconds before the date."""
    names = {name for fields in parts for name in fields if STAMP.fullmatch(name) or name == DATE}
    return max(names, key=lambda name: (name != DATE, sum(name in fields for fields in parts), name), default="")


def _value(text: str) -> Decimal | None:
    """A number, or seconds since 1970 of a date as HTTP has it (RFC 9110)."""
    try:
        value = Decimal(text)
        return value if value.is_finite() else None
    except InvalidOperation:
        pass
    try:
        return Decimal(str(email.utils.parsedate_to_datetime(text).timestamp()))
    except ValueError:
        return None
