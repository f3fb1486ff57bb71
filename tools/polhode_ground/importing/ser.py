"""SER, the format of astronomers' videos: its times stand behind the pictures, where FFmpeg does not look."""

import pathlib

import numpy as np

HEADER, WIDTH_AT, DEPTH_AT, COUNT_AT = 178, 26, 34, 38
RGB, BGR, COLOUR_AT = 100, 101, 18
TICK_NS = 100
EPOCH_TICKS = 621_355_968_000_000_000  # 1970 in ticks since the year 1


def times_of_ser(path: pathlib.Path) -> list[int] | None:
    """Of its pictures; None where the file has none."""
    with open(path, "rb") as file:
        octets = file.read(HEADER)
    width, height, bits, count = (int(np.frombuffer(octets, "<i4", 1, at)[0]) for at in (WIDTH_AT, WIDTH_AT + 4, DEPTH_AT, COUNT_AT))
    planes = 3 if int(np.frombuffer(octets, "<i4", 1, COLOUR_AT)[0]) in (RGB, BGR) else 1
    begin = HEADER + count * width * height * planes * (2 if bits > 8 else 1)
    if count < 1 or path.stat().st_size < begin + 8 * count:
        return None
    ticks = np.fromfile(path, "<i8", count, offset=begin)
    return ((ticks - EPOCH_TICKS) * TICK_NS).tolist() if np.all(np.diff(ticks) >= 0) and ticks[0] > EPOCH_TICKS else None
