"""Where the target is drawn: its points, origin and axes from what the packets say of its shape."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from polhode_ground.reporting.drawing import draw_target
from polhode_ground.watching.state import Pose, State

CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
EDGES = np.array([(a, b) for a in range(8) for b in range(a + 1, 8) if np.count_nonzero(CORNERS[a] != CORNERS[b]) == 1])
AXIS_LENGTH = 0.75  # of the greatest dimension: axes stand out of the body
INNER_PERCENT = 90  # of a raw cloud: the rest has outliers, which would be its hull
SIZE_UNKNOWN = 0.08  # of the distance: axes of a body whose shape is not known yet


@dataclass(frozen=True)
class Body:
    """In T; lengths as the packets have them."""

    points: np.ndarray  # [N,3] on the body; N = 0: nothing is known of its shape
    corners: np.ndarray  # [8,3] of the box of its dimensions, or [0,3]
    origin: np.ndarray  # [3]
    axes: np.ndarray  # [3,3], a row an axis, as long as it is drawn


def rotation(q: tuple[float, float, float, float]) -> Rotation:
    """Of w, x, y, z."""
    return Rotation.from_quat([*q[1:], q[0]])


def body_of(state: State, distance: float) -> Body:
    """@param distance  of T's origin from the camera."""
    shape, cloud, none = state.latest.get("shape"), np.array(state.cloud_T, dtype=float).reshape(-1, 3), np.zeros((0, 3))
    if shape is not None and shape.shape_valid:
        turn, origin, size = rotation(shape.q_TB), np.array(shape.centroid_T), np.array(shape.dimensions)
        corners = turn.apply(CORNERS * size) + origin
        return Body(corners, corners, origin, turn.as_matrix().T * AXIS_LENGTH * max(size.max(), 1e-9))
    if len(cloud) > 2:
        origin = np.median(cloud, axis=0)
        far = np.linalg.norm(cloud - origin, axis=1)
        size = float(np.percentile(far, INNER_PERCENT))
        return Body(cloud[far <= size], none, origin, np.eye(3) * max(size, 1e-9))
    return Body(none, none, np.zeros(3), np.eye(3) * SIZE_UNKNOWN * distance)


def picture_of(gray: np.ndarray, camera, pose: Pose | None, body: Body, width_px_max: int) -> np.ndarray:
    """RGB [H,W,3] no wider than that, with the body's outline and axes where it has a pose."""
    picture = cv2.cvtColor(np.ascontiguousarray(gray), cv2.COLOR_GRAY2BGR)
    if pose is not None and camera is not None:
        draw_target(picture, camera, rotation(pose.q_CT), np.array(pose.p_CT), body.points, body.origin, body.axes)
    if picture.shape[1] > width_px_max:
        scale = width_px_max / picture.shape[1]
        picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return picture[:, :, ::-1]


def quaternion(axes: np.ndarray) -> np.ndarray:
    """w, x, y, z of the rotation that takes the unit axes to these rows."""
    return Rotation.from_matrix(axes.T).as_quat()[[3, 0, 1, 2]]
