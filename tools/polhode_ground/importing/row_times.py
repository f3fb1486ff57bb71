"""The time from one row of a rolling shutter to the next, as calibrations and sensor.yaml tell it."""

import math
import re

from polhode_ground.common.errors import BadInput

UNITS_NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
LINE = re.compile(r"(?:line|row)(?:time|delay|period)(ns|us|ms|s)?")
OTHERS = re.compile(r"rollingshutter.*|.*readouttime.*")
SHUTTER = re.compile(r"shutter(type|mode)?")
KALIBR = "linedelay"  # in seconds


def row_time_of(values: dict, where: str) -> tuple[float, str]:
    """(nanoseconds from one row to the next, 0 where nothing tells it; what is to be said)."""
    for name, value in values.items():
        plain = re.sub("[^a-z0-9]", "", str(name).lower())
        line = LINE.fullmatch(plain)
        rolls = SHUTTER.fullmatch(plain) and "rolling" in str(value).lower()
        if not (line or rolls or OTHERS.fullmatch(plain)) or value in (None, False, 0, "global"):
            continue
        unit = line and (line[1] or ("s" if plain == KALIBR else None))
        if not unit:
            return (
                0.0,
                f"{where}: {name}: {value}: a rolling shutter, whose time from one row to the next is not told in a known unit: state line_time_ns in sensor.yaml",
            )
        try:
            time_ns = float(value) * UNITS_NS[unit]
        except (TypeError, ValueError):
            time_ns = math.nan
        if not math.isfinite(time_ns):
            raise BadInput(f"{where}: {name}: '{value}' is not a number")
        if name == "line_time_ns":
            return time_ns, ""
        return time_ns, f"{where}: {name}: {value}: line_time_ns is {time_ns:.10g}, and a stamp is taken to be the middle row's"
    return 0.0, ""
