"""What the pages of a TIFF are, and the time from one to the next, as microscopes' programs write it: ImageJ's text, OME's XML."""

import re
from dataclasses import dataclass, replace

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.source import Options

IMAGE_DESCRIPTION = 270
FIRST = "ImageJ="
LINE = r"^{}=(.+?)\s*$"
PIXELS, CHANNEL = re.compile(r"<Pixels\b[^>]*>"), re.compile(r"<Channel\b[^>]*>")
ATTRIBUTE = r'\b{}="([^"]*)"'
SECONDS = {
    "s": 1.0,
    "sec": 1.0,
    "second": 1.0,
    "seconds": 1.0,
    "ms": 1e-3,
    "msec": 1e-3,
    "us": 1e-6,
    "usec": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "\\u00b5s": 1e-6,
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
IMAGEJ_ORDER = "XYCZT"
ANY, ALL_PAGES = Options().camera, "pages"
SHORT, WORDS = {"C": "c", "Z": "z"}, {"C": "channels", "Z": "slices"}


@dataclass(frozen=True)
class Header:
    """Of the first page; a count of 0 is not told. The order is that of OME: what counts fastest stands first, after X and Y."""

    who: str
    who_tells_time: str
    frames: int
    channels: int
    slices: int
    order: str
    interval_s: float
    names: tuple[str, ...] = ()  # of the channels

    @property
    def in_a_moment(self) -> int:
        return max(1, self.channels) * max(1, self.slices)


def header_of(tags: dict) -> Header | None:
    """@param tags  of the first page"""
    text = tags.get(IMAGE_DESCRIPTION) or ""
    text = (text if isinstance(text, bytes) else str(text).encode("latin-1", errors="replace")).decode(
        errors="replace"
    )  # Pillow has UTF-8 as Latin-1
    if text.startswith(FIRST):

        def told(name):
            return re.search(LINE.format(name), text, re.MULTILINE)

        return Header(
            "ImageJ",
            "ImageJ's finterval",
            *map(_count, map(told, ("frames", "channels", "slices"))),
            IMAGEJ_ORDER,
            _seconds(told("finterval"), told("tunit")),
        )
    pixels = PIXELS.search(text)
    if pixels is None:
        return None

    whole = pixels.group()

    def has(name, tag=whole):
        return re.search(ATTRIBUTE.format(name), tag)

    channels = CHANNEL.findall(text[pixels.start() : text.find("</Pixels>") + 1 or len(text)])
    names = tuple(found.group(1) if (found := has("Name", tag)) else "" for tag in channels)
    # Of colours in one page SizeC counts each, and they are one channel.
    count = len(channels) or _count(has("SizeC"))
    order = found.group(1) if (found := has("DimensionOrder")) else IMAGEJ_ORDER
    return Header(
        "OME",
        "OME's TimeIncrement",
        _count(has("SizeT")),
        count,
        _count(has("SizeZ")),
        order,
        _seconds(has("TimeIncrement"), has("TimeIncrementUnit")),
        names,
    )


def _count(found) -> int:
    return int(found.group(1)) if found and found.group(1).isdecimal() else 0


def _seconds(interval, unit) -> float:
    try:
        value = float(interval.group(1)) * SECONDS[unit.group(1).strip().lower() if unit else "s"]
        return value if value > 0 else 0.0
    except (AttributeError, KeyError, ValueError):
        return 0.0


def frames_in(header: Header | None, pages: int, camera: str, where: str) -> tuple[range, float, str]:
    """(places of the pages that are frames, seconds from one to the next or 0 where nobody tells them, what was chosen).
    @errors BadInput where several pages are of one moment, and `camera` does not say which"""
    if header is None or camera == ALL_PAGES:
        return range(pages), 0.0, "all pages are taken for frames, as --camera says" if header else ""
    if header.frames * max(1, header.slices) == pages:
        header = replace(header, channels=1)  # colours of a page
    if header.channels < 2 and (header.slices < 2 or header.frames < 2):  # ImageJ calls the frames of films slices, too
        said = f"{header.who} calls the pages slices, which are heights: they are taken for frames" if header.slices > 1 else ""
        return range(pages), header.interval_s if header.frames in (0, pages) else 0.0, said
    several = [(axis, count) for axis, count in zip("CZ", (header.channels, header.slices)) if count > 1]
    frames = max(1, header.frames)
    found = f"{where}: {header.who} says that the {pages} pages are {' and '.join(f'{count} {WORDS[axis]}' for axis, count in several)} of {frames} moments"
    if header.in_a_moment * frames != pages:
        raise BadInput(f"{found}: these are {header.in_a_moment * frames}; --camera {ALL_PAGES} takes all pages for frames")
    chosen = _chosen(header, several, camera.casefold())
    if chosen is None:
        names = ", ".join(f"{number + 1}: {name}" for number, name in enumerate(header.names) if name)
        example = "".join(f"{SHORT[axis]}1" for axis, _ in several)
        last = "".join(f"{SHORT[axis]}{count}" for axis, count in several)
        raise BadInput(
            f"{found}{names and f' (channels {names})'}: choose by --camera {example} ... {last}; --camera {ALL_PAGES} takes all for frames"
        )
    sizes = {"C": max(1, header.channels), "Z": max(1, header.slices), "T": frames}
    places, step = dict.fromkeys("CZT", 0), 1
    for axis in [axis for axis in header.order if axis in sizes]:
        places[axis], step = step, step * sizes[axis]
    begin = sum(places[axis] * chosen.get(axis, 0) for axis in "CZ")
    said = " and ".join(f"{WORDS[axis][:-1]} {chosen[axis] + 1} of {count}" for axis, count in several)
    return range(begin, begin + places["T"] * frames, places["T"]), header.interval_s, f"{said} is taken, as --camera says"


def _chosen(header: Header, several: list[tuple[str, int]], camera: str) -> dict[str, int] | None:
    """Numbers from 0 by axis, of c2, z3, c2z3 or of a channel's name."""
    names = [name.casefold() for name in header.names]
    if names.count(camera) == 1 and len(several) == 1 and several[0][0] == "C":
        return {"C": names.index(camera)}
    found = re.fullmatch("".join(rf"{SHORT[axis]}(\d+)" for axis, _ in several), camera)
    numbers = [int(number) - 1 for number in found.groups()] if found else []
    return (
        dict(zip((axis for axis, _ in several), numbers))
        if numbers and all(0 <= number < count for number, (_, count) in zip(numbers, several))
        else None
    )
