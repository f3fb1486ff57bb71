"""Stamps as dates and as the times of SPICE. A stamp counts nanoseconds from 1970-01-01T00:00:00 of its clock's scale.

"utc": Unix time, as a computer's clock counts it, which knows no leap seconds. "tai": every second is counted.
"""

import pathlib
import re
from dataclasses import dataclass

import numpy as np

from polhode_ground.common.errors import BadInput

NS = 1_000_000_000
CLOCKS = ("utc", "tai")
TT_LESS_TAI_S = 32.184
J2000_S = 946_728_000  # 2000-01-01T12:00:00 in a clock's own seconds; J2000 is that date of TT
YEAR_2000_NS = 946_684_800 * NS
FIRST_LEAP_YEAR = 1972
UNIX_EPOCH_DAY = 40587  # modified Julian day of 1970-01-01


def date_of(time_ns: int) -> str:
    """As CCSDS writes it, with all nine digits. The calendar of UTC and TAI is the same: only its name tells them apart."""
    return str(np.datetime64(int(time_ns), "ns"))


def doubt_of(time_ns: int) -> str | None:
    """What must be said of a clock that nobody set."""
    if time_ns >= YEAR_2000_NS:
        return None
    return f"stamps begin at {date_of(time_ns)}: that clock was not set to the date, so only differences of times mean anything"


@dataclass(frozen=True)
class LeapSeconds:
    """From each second of Unix time on TAI is ahead of UTC by so much; the table is known to be whole until `expires`."""

    unix_s: np.ndarray
    tai_less_utc_s: np.ndarray
    expires: str

    def at(self, unix_s: int, clock: str) -> float:
        """TAI less the clock at a second of that clock."""
        if clock == "tai":
            return 0.0
        before = np.flatnonzero(self.unix_s <= unix_s)
        if not len(before):
            raise BadInput(
                f"stamps begin at {date_of(unix_s * NS)}: UTC as we know it begins in {FIRST_LEAP_YEAR}, so its leap seconds there are unknown; allowed is --clock tai"
            )
        return float(self.tai_less_utc_s[before[-1]])


def leap_seconds() -> LeapSeconds:
    """IERS' table, which is installed with astropy. Nothing is fetched."""
    from astropy_iers_data import IERS_LEAP_SECOND_FILE

    text = pathlib.Path(IERS_LEAP_SECOND_FILE).read_text()
    modified_julian_day, _, _, _, tai_less_utc_s = np.loadtxt(text.splitlines(), unpack=True)
    expires = re.search(r"File expires on (.*)", text)
    return LeapSeconds(
        (modified_julian_day.astype(np.int64) - UNIX_EPOCH_DAY) * 86400, tai_less_utc_s, expires.group(1) if expires else "an unknown day"
    )


def terrestrial_s(second: int, clock: str, leaps: LeapSeconds) -> float:
    """TT in seconds past J2000 of a whole second of the clock."""
    return (second - J2000_S) + leaps.at(second, clock) + TT_LESS_TAI_S
