"""A run with everything that an export must not pass over: losses, a prediction, two frames T, missing frames, a scale found late."""

import csv
import pathlib

import numpy as np
from polhode_ground.testing.synthetic import MOTION_HEADER, Errors, box_points, estimate_of, tumbling_body, write_ply
from scipy.spatial.transform import Rotation

START_NS = 1_700_000_000_123_456_789  # digits down to the nanosecond, which seconds as a float lose
FRAMES = 30
ACQUIRED, LOST, COASTED, SECOND_T, SCALED, MISSING = 3, 8, (9, 10), 16, 5, 24
# (first, last frame) of each run of frames with estimated poses in one T.
RUNS = ((3, 7), (11, 15), (16, 23), (24, 29))
POSES = [frame for first, last in RUNS for frame in range(first, last + 1)]
KM = 1e-3


def target_of(frame: int) -> int:
    return 1 + (frame >= SECOND_T)


def stamp(frame: int) -> int:
    """A third of a second, and two frames more before MISSING."""
    return START_NS + 333_333_333 * (frame + 2 * (frame >= MISSING))


def rows() -> list[list]:
    body = tumbling_body(frames=FRAMES, step_s=1 / 3)
    made = estimate_of(body, Errors(attitude_rms_rad=0.01, position_rms_m=0.02))
    table = []
    for frame in range(FRAMES):
        known = frame >= ACQUIRED and frame != LOST
        mode = "ACQUIRING" if frame < ACQUIRED else "LOST" if frame == LOST else "COASTING" if frame in COASTED else "TRACKING"
        values = [f"{value:.10g}" for name in ("q_CT", "p_CT", "v_C", "w_T") for value in made[name][frame]] + ["0.01", "0.02", "0.003", "0.004"]
        table.append([frame, stamp(frame), mode, *[int(known)] * 3, int(known and frame >= SCALED), *(values if known else [""] * len(values)),
                      200, 150, 100, 400, 9, "", *((target_of(frame), target_of(frame) + (frame >= SCALED)) if known else ("", ""))])
    return table


def write_eventful(folder: pathlib.Path) -> pathlib.Path:
    """motion.csv with the events above; motion_smoothed.csv, whose T is another, with a pose at every frame and metres."""
    folder.mkdir(parents=True)
    table = rows()
    smoothed = [[*row[:2], "TRACKING", 1, 1, 1, 1, *row[7:-2], 1, 1] for row in table]
    turn = Rotation.from_rotvec([1, 2, 0.5])
    for row in smoothed:
        q = Rotation.from_rotvec([0.1, 0.2, 0.02 * row[0]]) * turn
        row[7:14] = [f"{value:.10g}" for value in (*q.as_quat(scalar_first=True), 0.1, 0.2, 5.0)]
        row[14:20] = ["0.001", "0", "0", "0", "0", "0.06"]
        row[20:24] = ["0.01", "0.02", "0.003", "0.004"]
    for name, lines in (("motion.csv", table), ("motion_smoothed.csv", smoothed)):
        with open(folder / name, "w", newline="") as stream:
            csv.writer(stream).writerows([[*MOTION_HEADER, "scale_number"], *lines])
    write_ply(folder / "cloud.ply", box_points(50))
    return folder


def call(*arguments) -> None:
    """tools/export.py in this process. @raise BadInput as it does"""
    import sys
    from unittest import mock

    from polhode_ground.exporting import export
    with mock.patch.object(sys, "argv", ["export.py", *map(str, arguments)]):
        export.main()


def quaternion_error_rad(left: np.ndarray, right: np.ndarray) -> float:
    """Largest angle between rows [N,4] of scalar-first quaternions, whatever their sign: of arc sine, exact for small ones."""
    difference = Rotation.from_quat(left, scalar_first=True).inv() * Rotation.from_quat(right, scalar_first=True)
    return float(difference.magnitude().max())
