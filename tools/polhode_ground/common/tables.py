"""Reads the project's CSV files into arrays. An empty cell is NaN (unknown), never zero."""

import csv
import pathlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from polhode_ground.common.delimited import rows_of, separator_of, text_of
from polhode_ground.common.errors import BadInput

QUATERNION = ("q_CT_w", "q_CT_x", "q_CT_y", "q_CT_z")
POSITION = ("p_CT_x", "p_CT_y", "p_CT_z")
VELOCITY = ("v_C_x", "v_C_y", "v_C_z")
RATE = ("w_T_x", "w_T_y", "w_T_z")
FLAGS = ("pose_valid", "rate_valid", "velocity_valid", "scale_known")
SIGMAS = ("sigma_att_rad", "sigma_pos", "sigma_vel", "sigma_rate_rad_s")
COUNTS = ("features", "matches", "inliers", "landmarks", "keyframes")
COST = ("step_us",)
TARGET_FRAME = "target_frame"
# A quaternion farther than this from unit norm is no rounding of a printed one, but a broken file.
QUATERNION_NORM_ERROR_MAX = 1e-2


@dataclass
class Motion:
    """N rows of motion.csv, motion_smoothed.csv or truth.csv. Unknown values are NaN.

    q_CT [N,4] w,x,y,z; p_CT [N,3] in m or map units; v_C [N,3] per second; w_T [N,3] rad/s.
    """

    path: pathlib.Path
    timestamp_ns: np.ndarray
    q_CT: np.ndarray
    p_CT: np.ndarray
    v_C: np.ndarray
    w_T: np.ndarray
    pose_valid: np.ndarray
    rate_valid: np.ndarray
    velocity_valid: np.ndarray
    scale_known: np.ndarray
    mode: list[str] = field(default_factory=list)
    columns: dict[str, np.ndarray] = field(default_factory=dict)
    remark: str = ""  # of a truth: how its rows became those of frames
    target_frame: np.ndarray | None = None  # [N] number of the frame T that a row's pose is in; None: all are in one

    @property
    def seconds(self) -> np.ndarray:
        """[N] time since the first row [s]."""
        return np.asarray((self.timestamp_ns - self.timestamp_ns[0]) * 1e-9)


def read_cells(path: pathlib.Path) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a CSV file, white space and a leading '#' taken off; every row as long as the header."""
    try:
        text = text_of(path)
        rows = rows_of(text, "," if separator_of(text) == " " else separator_of(text))
    except csv.Error as problem:
        raise BadInput(f"{path}: not a CSV text file ({problem})") from None
    if not rows:
        raise BadInput(f"{path}: empty, a header line is needed")
    header = [name.lstrip("#").strip() for name in rows[0][1]]
    body = [(number, row) for number, row in rows[1:] if not row[0].startswith("#")]
    for number, row in body:
        if len(row) != len(header):
            raise BadInput(f"{path}:{number}: {len(row)} cells where the header has {len(header)}")
    return header, [row for _, row in body]


def numbers(path: pathlib.Path, name: str, cells: Sequence[str]) -> np.ndarray:
    """Cells as float64 [N]; empty or 'nan' is NaN."""
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells], dtype=float)
    except ValueError:
        for number, cell in enumerate(cells, start=2):
            try:
                float(cell or "nan")
            except ValueError:
                raise BadInput(f"{path}:{number}: {name} is '{cell}', not a number") from None
        raise


def timestamps(path: pathlib.Path, cells: Sequence[str]) -> np.ndarray:
    """Cells as int64 [N] nanoseconds, strictly rising: float64 would lose digits of times since 1970."""
    try:
        timestamp_ns = np.array([int(cell) for cell in cells], dtype=np.int64)
    except (ValueError, OverflowError):
        raise BadInput(f"{path}: timestamp_ns holds something that is not a whole number") from None
    if np.any(np.diff(timestamp_ns) <= 0):
        row = int(np.argmax(np.diff(timestamp_ns) <= 0)) + 3
        raise BadInput(f"{path}:{row}: timestamp_ns does not rise")
    return timestamp_ns


def _unit_quaternions(path: pathlib.Path, q_CT: np.ndarray) -> np.ndarray:
    norm = np.linalg.norm(q_CT, axis=1)
    wrong = np.abs(norm - 1.0) > QUATERNION_NORM_ERROR_MAX
    if np.any(wrong):
        raise BadInput(f"{path}:{int(np.argmax(wrong)) + 2}: q_CT has norm {norm[np.argmax(wrong)]:.4g}, not 1")
    return np.asarray(q_CT / norm[:, None])


def read_motion(path: pathlib.Path) -> Motion:
    """Reads motion.csv, motion_smoothed.csv or truth.csv (whose poses are valid wherever they are written)."""
    path = pathlib.Path(path)
    header, rows = read_cells(path)
    missing = [name for name in ("timestamp_ns", *QUATERNION, *POSITION) if name not in header]
    if missing:
        raise BadInput(f"{path}: column {missing[0]} is missing")
    if not rows:
        raise BadInput(f"{path}: no rows after the header")
    cells = dict(zip(header, zip(*rows)))
    known = {
        name: numbers(path, name, cells[name])
        for name in (*QUATERNION, *POSITION, *VELOCITY, *RATE, *FLAGS, *SIGMAS, *COUNTS, *COST, TARGET_FRAME)
        if name in cells
    }
    unknown = np.full(len(rows), np.nan)

    def block(names: Sequence[str]) -> np.ndarray:
        return np.stack([known.get(name, unknown) for name in names], axis=1)

    q_CT, p_CT, v_C, w_T = (block(names) for names in (QUATERNION, POSITION, VELOCITY, RATE))

    def valid(flag: str, *values: np.ndarray) -> np.ndarray:
        filled: np.ndarray = np.all([np.isfinite(value).all(axis=1) for value in values], axis=0)
        return filled & (known[flag] > 0) if flag in known else filled

    # A predicted pose counts as silence.
    coasted = np.array(cells.get("mode", [""] * len(rows))) == "COASTING"
    return Motion(
        path=path,
        timestamp_ns=timestamps(path, cells["timestamp_ns"]),
        q_CT=_unit_quaternions(path, q_CT),
        p_CT=p_CT,
        v_C=v_C,
        w_T=w_T,
        pose_valid=valid("pose_valid", q_CT, p_CT) & ~coasted,
        rate_valid=valid("rate_valid", w_T),
        velocity_valid=valid("velocity_valid", v_C),
        scale_known=known.get("scale_known", unknown + 1) > 0,
        mode=list(cells.get("mode", [])),
        columns={name: known.get(name, unknown) for name in (*SIGMAS, *COUNTS, *COST)},
        target_frame=known.get(TARGET_FRAME),
    )


def target_frames(motion: Motion) -> list[int]:
    """Numbers of the frames T that poses are in, rising. A file without numbers has one, 0."""
    if motion.target_frame is None:
        return [0]
    numbers = motion.target_frame[motion.pose_valid]
    if not np.isfinite(numbers).all():
        raise BadInput(f"{motion.path}: target_frame is empty in a row with a pose")
    return [int(number) for number in np.unique(numbers)]


def in_frame(motion: Motion, number: int) -> Motion:
    """The motion with those of its values only that are in the frame T of that number."""
    if motion.target_frame is None:
        return motion
    here = motion.target_frame == number
    return replace(
        motion, pose_valid=motion.pose_valid & here, rate_valid=motion.rate_valid & here, velocity_valid=motion.velocity_valid & here
    )


def where_also(estimate: Motion, other: Motion) -> Motion:
    """The estimate with those of its poses only whose frames have one in the other file too."""
    shared = np.isin(estimate.timestamp_ns, other.timestamp_ns[other.pose_valid])
    return replace(estimate, pose_valid=estimate.pose_valid & shared)


def join(estimate: Motion, truth: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Row indices (into estimate, into truth) of equal time stamps; an error where there is none."""
    _, rows_estimate, rows_truth = np.intersect1d(estimate.timestamp_ns, truth.timestamp_ns, assume_unique=True, return_indices=True)
    if rows_estimate.size == 0:
        raise BadInput(f"{estimate.path}: shares no timestamp_ns with {truth.path}: another sequence?")
    return rows_estimate, rows_truth
