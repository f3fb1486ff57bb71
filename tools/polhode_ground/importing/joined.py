"""Finds videos that were put one behind the other in a file, as `cat a.mp4 b.mp4` does: readers stop at the end of the first, without a word."""

import mmap
import pathlib
import re
from collections.abc import Iterator

from polhode_ground.common.errors import BadInput

ASF_HEADER = bytes.fromhex("3026b2758e66cf11a6d900aa0062ce6c")
# How files begin whose reader does not go on with the next, with enough around it that no picture has these octets by chance.
BEGINNINGS = {
    "flv": re.compile(rb"FLV\x01[\x01\x04\x05]\0\0\0\x09\0\0\0\0"),
    "asf": re.compile(re.escape(ASF_HEADER)),
    "matroska,webm": re.compile(rb"\x1a\x45\xdf\xa3[^\x1a]{1,64}?\x42\x82[\x80-\xff].{0,7}?(?:webm|matroska)", re.DOTALL),
    "avi": re.compile(rb"RIFF.{4}AVI LIST", re.DOTALL),
}
LARGE_BOX, TO_THE_END = 1, 0  # sizes that mean something else (ISO 14496-12)
TOO_MANY_BOXES = 1_000_000


class JoinedVideos(BadInput):
    """A video that can be read, but not all of it at once."""


def check_is_one(path: pathlib.Path, container: str) -> None:
    """@param container  FFmpeg's name of it. @errors JoinedVideos where another video begins behind the first"""
    if not path.is_file() or not path.stat().st_size:
        return
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as octets:
        begins = (
            _files_of_boxes(octets)
            if container.startswith("mov")
            else [found.start() for found in BEGINNINGS[container].finditer(octets)]
            if container in BEGINNINGS
            else []
        )
    if len(begins) > 1:
        raise JoinedVideos(
            f"{path}: {len(begins)} videos one behind the other in one file, the second from octet {begins[1]} on: how long the pause "
            "between them is, the file does not tell; import each by itself, or, where there is none, join them by FFmpeg's `-f concat`"
        )


def _files_of_boxes(octets) -> list[int]:
    """Where files of MP4 or QuickTime begin: with `ftyp`; old QuickTime has none, there each `moov` is one."""
    begins = {b"ftyp": [], b"moov": []}
    for at, kind in _boxes(octets):
        if kind in begins:
            begins[kind].append(at)
    return max(begins.values(), key=len)


def _boxes(octets) -> Iterator[tuple[int, bytes]]:
    """(place, kind) of those that are in no other."""
    at = 0
    for _ in range(TOO_MANY_BOXES):
        head = octets[at : at + 16]
        if len(head) < 8:
            return
        size = int.from_bytes(head[:4], "big")
        if size == LARGE_BOX:
            size = int.from_bytes(head[8:16], "big")
        yield at, head[4:8]
        if size == TO_THE_END or size < 8:
            return
        at += size
