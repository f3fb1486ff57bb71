"""What a user says of the truth on the command line."""

import argparse
import pathlib

from polhode_ground.common.ranges import number
from polhode_ground.judge.truth import GAP_MAX_S


def add_truth_options(parser: argparse.ArgumentParser, truth_help: str) -> None:
    parser.add_argument("--truth", metavar="FILE", type=pathlib.Path, help=truth_help)
    parser.add_argument(
        "--truth-gap-s",
        metavar="S",
        type=number(1e-6, 1e6),
        default=GAP_MAX_S,
        help=f"truth with stamps of its own is interpolated between rows at most so far apart (default: {GAP_MAX_S:g})",
    )
    parser.add_argument(
        "--clock-offset",
        metavar="S",
        type=_offset,
        default=0.0,
        help="how far the truth's clock is ahead of the frames', in s; 'auto': estimated from the run's motion (default: 0)",
    )


def _offset(text: str) -> float | None:
    return None if text == "auto" else number(-1e9, 1e9)(text)
