"""Netpbm files hold one picture or several, one behind the other: https://netpbm.sourceforge.net/doc/pgm.html."""

import mmap
import pathlib
import re

BLANK = rb"(?:\s|#[^\n]*\n)+"
HEADERS = {
    kind: re.compile(rb"\s*P" + kind + rb"".join(BLANK + rb"(\d{1,9})" for _ in range(numbers)) + rb"\s")
    for kind, numbers in ((b"4", 2), (b"5", 3), (b"6", 3))
}


def places_of(octets) -> list[tuple[int, int]]:
    """(begin, end) of each binary picture; what follows the last is no picture. Empty: it is no binary one."""
    places, begin = [], 0
    while found := next(filter(None, (header.match(octets, begin) for header in HEADERS.values())), None):
        width, height, *largest = map(int, found.groups())
        row = (
            (width + 7) // 8 if not largest else width * (3 if found[0].lstrip().startswith(b"P6") else 1) * (2 if largest[0] > 255 else 1)
        )
        places.append((begin, found.end() + row * height))
        begin = places[-1][1]
    return places


def pages_of(path: pathlib.Path) -> list[tuple[int, int]]:
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as octets:
        return places_of(octets)
