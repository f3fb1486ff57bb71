"""What the two bodies and their frames are called, and how a user may call them."""

import argparse
import re
from dataclasses import dataclass

NAME = re.compile(r"[A-Z0-9][A-Z0-9_+./-]{0,25}")
# T of the smoothed poses has other axes than T of the published ones, though both are counted from 1.
SMOOTHED_FROM = 100


@dataclass(frozen=True)
class Names:
    target: str
    target_id: str
    servicer: str
    camera_frame: str
    body_frame: str
    originator: str

    def frame_of(self, target: int, kind: str) -> str:
        """The name of a frame T."""
        return f"{self.body_frame}_{frame_number(target, kind)}"


def frame_number(target: int, kind: str) -> int:
    return target + (SMOOTHED_FROM if kind == "smoothed" else 0)


def name(text: str) -> str:
    """For argparse: what all of these formats take."""
    if not NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(f"'{text}': allowed are 1 to 26 of A-Z, 0-9 and _ + . / -, the first a letter or digit")
    return text


def definition(target: int, kind: str, source: str, names: Names) -> list[str]:
    """What a reader of a file has to know of the two frames, in sentences."""
    other = "motion.csv" if kind == "smoothed" else "motion_smoothed.csv"
    return [
        f"{names.camera_frame} is the camera's frame C: x right, y down in the image, z forward; origin in its centre of projection",
        f"{names.frame_of(target, kind)} is the target frame T number {target} of {source}: fixed to the body, origin near its centroid",
        f"T of {other}, and T of another number, have other axes and another origin",
    ]
