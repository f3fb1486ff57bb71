"""Arguments of import_sequence.py, checked; a wrong one gets one line with what is allowed."""

import argparse
import math
import re

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.lens import Lens, lens_of

NUMBERS = re.compile(r"[-+\d.eE,;\s]+")


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text}: not a number")
    return value


def positive(text: str) -> float:
    value = _number(text)
    if not 0 < value <= 1e6:
        raise argparse.ArgumentTypeError(f"{text}: out of range, allowed is 0 < value <= 1000000")
    return value


def seconds(text: str) -> float:
    value = _number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text}: out of range, allowed is at least 0")
    return value


def at_least_one(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: allowed is a whole number of at least 1")
    return int(text)


def lens_of_numbers(text: str) -> Lens | None:
    """'fu,fv,cu,cv' in pixels, without distortion, for pictures of any size; None where the text is no such list."""
    parts = re.split(r"\s*[,;]\s*|\s+", text.strip())
    if len(parts) != 4 and len(parts) > 1 and NUMBERS.fullmatch(text):
        raise BadInput(f"--intrinsics {text}: {len(parts)} numbers, needed are 4 with decimal points: fu,fv,cu,cv")
    if len(parts) != 4 or not ("," in text or NUMBERS.fullmatch(text)):
        return None
    return lens_of(0, 0, parts, "none", (), f"--intrinsics {text}")
