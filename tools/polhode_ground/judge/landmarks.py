"""Where the landmarks and the outlines of a run lie, by the truth's silhouettes."""

import csv
import pathlib
from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import numpy as np

from polhode_ground.common.sequence import Sequence
from polhode_ground.judge.shape import read_landmark_numbers
from polhode_ground.judge.silhouette import Silhouettes, overlap

# A landmark on the rim of the body is seen this far outside of it by its own error and the mesh's.
RIM_PX = 2


def outline_overlaps(masks: Iterable[Any], sequence: Sequence) -> list[float]:
    """Intersection over union of the outlines of keyframes before a background with the true silhouette."""
    sharp = [mask for mask in masks if mask.sharp]
    if not sharp:
        return []
    silhouettes, camera = Silhouettes(sequence), sequence.camera
    return [
        overlap(mask.full("target", camera.height_px, camera.width_px), silhouettes.of(sequence.timestamp_ns[mask.frame])) for mask in sharp
    ]


def on_background(run_folder: pathlib.Path, sequence: Sequence) -> tuple[int, int]:
    """(landmarks that lie outside the silhouette in most of the frames that saw them, landmarks of the final map).

    The final map is that of cloud_raw.ply; where it does not number its landmarks, all those count that were ever seen as
    inliers in at least three frames.
    """
    from scipy.ndimage import binary_dilation

    sightings: dict[int, list[bool]] = defaultdict(list)
    by_frame: dict[int, list[tuple[int, float, float]]] = defaultdict(list)
    with open(run_folder / "observations.csv", newline="") as file:
        for seen_at in csv.DictReader(file):
            if seen_at["landmark"] and seen_at["inlier"] == "1":
                by_frame[int(seen_at["frame"])].append((int(seen_at["landmark"]), float(seen_at["u_px"]), float(seen_at["v_px"])))
    silhouettes, camera = Silhouettes(sequence), sequence.camera
    for frame, seen in by_frame.items():
        target = binary_dilation(silhouettes.of(sequence.timestamp_ns[frame]), iterations=RIM_PX)
        for landmark, u, v in seen:
            column = min(max(int(round(u)), 0), camera.width_px - 1)
            row = min(max(int(round(v)), 0), camera.height_px - 1)
            sightings[landmark].append(not target[row, column])
    final = read_landmark_numbers(run_folder / "cloud_raw.ply")
    kept = {landmark: outside for landmark, outside in sightings.items() if (len(outside) >= 3 if final is None else landmark in final)}
    return sum(bool(np.mean(outside) > 0.5) for outside in kept.values()), len(kept)
