"""A made-up sequence whose truth can be measured in its pictures: bright dots on a plate that turns before a camera."""

import pathlib

import numpy as np
import trimesh
from polhode_ground.common.fault_log import LogEntry
from polhode_ground.common.sequence import Camera
from polhode_ground.transforms.footage import Footage, Shot, write_footage
from scipy.spatial.transform import Rotation

FRAMES, PERIOD_S, START_NS = 40, 0.5, 1_700_000_000_000_000_000
PLATE_M = (0.9, 0.7, 0.02)
DOTS_T = np.array([(-0.38, -0.28, 0), (0.3, -0.26, 0), (-0.1, -0.05, 0), (0.36, 0.1, 0), (-0.33, 0.22, 0), (0.12, 0.27, 0)])
SPREAD_PX = 1.6
RATE_RAD_S = 0.2
CAMERA = Camera(320, 240, np.array([520.0, 516.0, 163.3, 117.6]), np.array([-0.12, 0.05, 0.001, -0.002]))


def pose(time_s: float) -> tuple[Rotation, np.ndarray]:
    """R_CT and p_CT: a tilted plate that turns about its normal and drifts. Its face stays in sight."""
    return Rotation.from_rotvec([0.35, -0.2, 0.1]) * Rotation.from_rotvec([0, 0, RATE_RAD_S * time_s]), \
        np.array([0.1 - 0.006 * time_s, -0.08 + 0.004 * time_s, 3.4 - 0.01 * time_s])


def picture(time_s: float) -> np.ndarray:
    R_CT, p_CT = pose(time_s)
    v, u = np.mgrid[0 : CAMERA.height_px, 0 : CAMERA.width_px]
    light = np.full(u.shape, 20.0)
    for centre in CAMERA.project(R_CT.apply(DOTS_T) + p_CT):
        light += 180 * np.exp(-((u - centre[0]) ** 2 + (v - centre[1]) ** 2) / (2 * SPREAD_PX**2))
    return np.rint(np.clip(light, 0, 255)).astype(np.uint8)


def footage(model: pathlib.Path | None) -> Footage:
    shots = []
    for frame in range(FRAMES):
        time_s = frame * PERIOD_S
        R_CT, p_CT = pose(time_s)
        shots.append(Shot(START_NS + round(1e9 * time_s), lambda t=time_s: picture(t), None, R_CT.as_quat(scalar_first=True), p_CT,
                          np.array([-0.006, 0.004, -0.01]), np.array([0, 0, RATE_RAD_S])))
    return Footage(CAMERA, 1 / PERIOD_S, shots, model, {"scene": {"motion": {"inertia_kg_m2": [[1.0, 0.1, 0.0], [0.1, 1.2, 0.0], [0, 0, 1.5]]}},
                                                        "bounding_box_T_m": [[-0.45, -0.35, -0.01], [0.45, 0.35, 0.01]]})


def write(folder: pathlib.Path) -> pathlib.Path:
    model = folder.parent / "plate.ply"
    trimesh.creation.box(PLATE_M).export(model)
    write_footage(footage(model), folder)
    return folder


def dots_px(gray: np.ndarray, near_px: np.ndarray, radius: int = 6) -> np.ndarray:
    """[N,2] centroid of the dot around each of the given pixels; NaN where there is none, or it is cut off."""
    found = np.full(near_px.shape, np.nan)
    for i, (u, v) in enumerate(np.rint(near_px).astype(int)):
        if radius < u < gray.shape[1] - radius - 1 and radius < v < gray.shape[0] - radius - 1:
            patch = gray[v - radius : v + radius + 1, u - radius : u + radius + 1].astype(float)
            patch = np.clip(patch - np.median(patch) - 12, 0, None)
            if patch.max() > 15:
                rows, columns = np.mgrid[-radius : radius + 1, -radius : radius + 1]
                found[i] = u + (patch * columns).sum() / patch.sum(), v + (patch * rows).sum() / patch.sum()
    return found


def spoiled(log: list[LogEntry]) -> set[int]:
    return {one.timestamp_ns for one in log}
