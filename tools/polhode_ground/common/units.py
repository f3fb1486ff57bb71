"""The unit of time stamps, judged by what cameras do: how far apart they are, and whether they count since 1970."""

import statistics
from collections.abc import Sequence
from typing import Any

NS = 1_000_000_000
UNITS = {"s": NS, "ms": 1_000_000, "us": 1_000, "ns": 1}
WORDS = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
# Between frames: what no camera does, and what few do.
IMPOSSIBLE_NS, DOUBTFUL_NS = (100_000, 3600 * NS), (1_000_000, 20 * NS)
USUAL_NS = (1_000_000, 5 * NS)
SINCE_1970_NS = (946_684_800 * NS, 3_000_000_000 * NS)  # the years 2000 to 2065


def median_step(values: Sequence[Any]) -> float:
    """0 where none rises."""
    return float(statistics.median([b - a for a, b in zip(values, values[1:]) if b > a] or [0]))


def is_impossible(step_ns: float) -> bool:
    return bool(step_ns) and not IMPOSSIBLE_NS[0] <= step_ns <= IMPOSSIBLE_NS[1]


def likely_units(values: Sequence[Any], stated: str) -> list[str]:
    """[stated] where nothing speaks against it; else the units that are likely in its place, none where nothing fits."""
    step = median_step(values)
    if not is_impossible(step * UNITS[stated]) and DOUBTFUL_NS[0] <= step * UNITS[stated] <= DOUBTFUL_NS[1] or len(values) < 3 or not step:
        return [stated]
    since_1970 = [
        unit
        for unit, scale in UNITS.items()
        if SINCE_1970_NS[0] <= float(values[len(values) // 2]) * scale < SINCE_1970_NS[1] and not is_impossible(step * scale)
    ]
    if since_1970 or not is_impossible(step * UNITS[stated]):
        return since_1970 or [stated]
    return [unit for unit, scale in UNITS.items() if USUAL_NS[0] <= step * scale <= USUAL_NS[1]]


def doubt(values: Sequence[Any], unit: str) -> str:
    """What is to be said of stamps in this unit that are as few cameras give them; else empty."""
    step_ns = median_step(values) * UNITS[unit]
    if len(values) < 3 or not step_ns or DOUBTFUL_NS[0] <= step_ns <= DOUBTFUL_NS[1]:
        return ""
    return f"the stamps are taken for {WORDS[unit]}: {step_ns / NS:.6g} s from frame to frame"
