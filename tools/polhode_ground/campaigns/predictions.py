"""Where points of the body will be, as a planner would ask: prediction packets of a run against the truth.

A packet tells the pose ahead with its covariance, so it tells every point of the body. Judged are the middles of the six
sides of the body's box: what is far from the mass centre has the attitude's error, too.
"""

import json
import pathlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from polhode_ground.campaigns.bus_file import packets_of, pose_covariance
from polhode_ground.common.tables import Motion
from polhode_ground.judge import align
from polhode_ground.judge.aligned import Aligned
from polhode_ground.judge.prediction import truth_at

AHEAD_S = (10, 60, 300)
SCENE_FILE = "scene.json"


@dataclass(frozen=True)
class Predicted:
    """One packet: T in C, as C was at `from_ns`; covariance [6,6] of (phi, dp)."""

    from_ns: int
    at_ns: int
    R_CE: Rotation
    p_CE: np.ndarray
    covariance: np.ndarray

    @property
    def ahead_s(self) -> float:
        return (self.at_ns - self.from_ns) * 1e-9


def read_predictions(bus_file: pathlib.Path) -> list[tuple[int, bool, Predicted]]:
    """[(frame, in metres?, what it predicted)] of the packets that have attitude and position."""
    return [
        (
            packet.frame,
            packet.scale_known,
            Predicted(
                packet.timestamp_ns,
                packet.predicted_timestamp_ns,
                align.rotations(np.array(packet.q_CT)),
                np.array(packet.p_CT),
                pose_covariance(packet.cov_pose),
            ),
        )
        for packet in packets_of(bus_file, "prediction")
        if packet.q_CT is not None and packet.p_CT is not None
    ]


def body_points(scene: dict[str, Any]) -> np.ndarray:
    """[6,3] the middles of the sides of the body's box in the truth's T [m]; its origin alone where the box is not known."""
    box = np.array(scene.get("bounding_box_T_m", np.zeros((2, 3))))
    middle, half = box.mean(axis=0), np.diff(box, axis=0)[0] / 2
    return np.unique(middle + np.concatenate([np.diag(half), -np.diag(half)]), axis=0)


def truth_later(truth: Motion, scene: dict[str, Any], at_ns: int) -> tuple[Rotation, np.ndarray] | None:
    """(R_CT, p_CT) by the rows of the truth, and beyond them by the motion that a rendered scene has; else None."""
    found = truth_at(truth, at_ns)
    if found is not None:
        return found[0], found[1]
    motion = scene.get("scene", {}).get("motion")
    if motion is None or at_ns < truth.timestamp_ns[0]:
        return None
    from polhode_ground.scenes.truth import motion_at

    later = motion_at(motion, [], np.array([(at_ns - scene["scene"]["time"]["epoch_ns"]) * 1e-9]))
    return align.rotations(later.q_CT[0]), later.p_CT_m[0]


def points_nees(predicted: Predicted, part: Aligned, points_T: np.ndarray, R_CT: Rotation, p_CT: np.ndarray) -> np.ndarray:
    """[P] squared error of each point over its covariance, expected 3."""
    similarity = part.own_similarity
    points_E = part.R_ET.apply(points_T) / similarity.scale + similarity.offset_E
    arms_C = predicted.R_CE.apply(points_E)
    result = []
    for arm, truth in zip(arms_C, R_CT.apply(points_T) + p_CT):
        by = np.hstack([-np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]]), np.eye(3)])
        covariance = by @ predicted.covariance @ by.T
        off = (truth - similarity.scale * (predicted.p_CE + arm)) / similarity.scale
        result.append(off @ np.linalg.solve(covariance, off))
    return np.array(result)


def judge_points(bus_file: pathlib.Path, sequence_folder: pathlib.Path, truth: Motion, parts: list[Aligned]) -> dict[str, Any]:
    """predicted_nees_10_s and so on: median over packets of the points' mean over 3 (1 is right); share beyond 99 %; packets.

    A camera that turns is left out: its axes at the time ahead are others.
    """
    file = sequence_folder / SCENE_FILE
    scene = json.loads(file.read_text()) if file.exists() else {}
    points_T = body_points(scene)
    found: dict[int, list[np.ndarray]] = {ahead: [] for ahead in AHEAD_S}
    turning = (sequence_folder / "servicer_attitude.csv").exists()
    for frame, metric, predicted in [] if turning else read_predictions(bus_file):
        part = next((one for one in parts if frame in one.rows_E and one.metric == metric), None)
        ahead = round(predicted.ahead_s)
        if part is None or ahead not in found:
            continue
        later = truth_later(truth, scene, predicted.at_ns)
        if later is not None:
            found[ahead].append(points_nees(predicted, part, points_T, *later))
    row: dict[str, Any] = {}
    for ahead, values in found.items():
        row[f"predicted_nees_{ahead}_s"] = float(np.median(np.mean(values, axis=1) / 3)) if values else None
        row[f"predicted_beyond_99_{ahead}_s"] = float(np.mean(np.array(values) > chi2.ppf(0.99, 3))) if values else None
        row[f"predictions_{ahead}_s"] = len(values)
    return row
