"""Picked frames with what was found drawn over them, as JPEGs within the page."""

import base64

import cv2
import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import in_frame, target_frames
from polhode_ground.judge import align
from polhode_ground.plots.series import cloud_and_path
from polhode_ground.reporting.drawing import draw_target
from polhode_ground.reporting.gather import Material

COUNT = 8
WIDTH_PX = 560


def overlaid(material: Material, index: int, points_T: np.ndarray | None, shape: dict) -> tuple[np.ndarray, bool]:
    """(frame in BGR with the body's outline and axes where it has a pose, whether it has)."""
    sequence = material.sequence
    picture = cv2.cvtColor(sequence.read_gray(index), cv2.COLOR_GRAY2BGR)
    motion = material.run.motions.get("smoothed")  # the cloud is in its frame T, the last one
    if motion is None or points_T is None or len(points_T) < 3 or not motion.pose_valid.any():
        return picture, False
    last = in_frame(motion, target_frames(motion)[-1])
    rows = np.flatnonzero((last.timestamp_ns == sequence.timestamp_ns[index]) & last.pose_valid)
    if len(rows) == 0:
        return picture, False
    R_CT, p_CT = align.rotations(motion.q_CT[rows])[0], motion.p_CT[rows[0]]
    origin = np.array(shape.get("centroid_T") or np.median(points_T, axis=0), dtype=float)
    size = float(np.percentile(np.linalg.norm(points_T - origin, axis=1), 90))
    axes = shape.get("axes") or {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}
    draw_target(picture, sequence.camera, R_CT, p_CT, points_T, origin, size * np.array(list(axes.values()), dtype=float))
    return picture, True


def picked(material: Material) -> list[dict]:
    """[{"title", "jpeg" (base64)}] of frames spread over the run; a frame that can't be read is said so."""
    sequence = material.sequence
    if sequence is None:
        return []
    found = cloud_and_path(material.run, None)
    points = found[0] if found is not None else None
    motion = material.run.motions.get("causal") or next(iter(material.run.motions.values()))
    count, shown = len(sequence.timestamp_ns), []
    for index in sorted({int(i) for i in np.linspace(0, count - 1, min(COUNT, count)).round()}):
        rows = np.flatnonzero(motion.timestamp_ns == sequence.timestamp_ns[index])
        mode = motion.mode[rows[0]].lower() if len(rows) and motion.mode else ""
        seconds = (sequence.timestamp_ns[index] - sequence.timestamp_ns[0]) * 1e-9
        try:
            picture, has_pose = overlaid(material, index, points, material.shape.get("shape") or {})
        except BadInput:
            shown.append({"title": f"frame {index}: can't be read", "jpeg": ""})
            continue
        scale = min(1.0, WIDTH_PX / picture.shape[1])
        small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        jpeg = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
        shown.append(
            {"title": f"frame {index}, {seconds:.1f} s, {mode}{'' if has_pose else ', no pose'}", "jpeg": base64.b64encode(jpeg).decode()}
        )
    return shown
