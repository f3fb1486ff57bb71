"""Numbers on the command line that are held to a range: types for argparse, which names the argument and refuses with status 2."""

import argparse
from collections.abc import Callable
from typing import TypeVar

Number = TypeVar("Number", int, float)


def _held(text: str, kind: type[Number], name: str, least: Number, most: Number | None) -> Number:
    allowed = f"at least {least}" if most is None else f"{least} .. {most}"
    try:
        value = kind(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no {name}, allowed is {allowed}") from None
    if not value >= least or (most is not None and not value <= most):  # so put that "nan" is refused
        raise argparse.ArgumentTypeError(f"{text}: out of range, allowed is {allowed}")
    return value


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """Whole numbers in least .. most."""
    return lambda text: _held(text, int, "whole number", least, most)


def number(least: float, most: float | None = None) -> Callable[[str], float]:
    """Numbers in least .. most."""
    return lambda text: _held(text, float, "number", least, most)
