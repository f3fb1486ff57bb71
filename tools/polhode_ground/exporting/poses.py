"""What a run's poses are to be written from: one motion file with its covariances, and the runs of frames without a gap in it."""

import pathlib
from dataclasses import dataclass, field, replace

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import Motion, numbers, read_cells, read_motion
from polhode_ground.judge.run import MOTION_FILES

# An interval between frames that is longer than this many usual ones is a gap.
GAP_INTERVALS = 1.5
# Packets hold all digits of what motion.csv prints with ten.
SAME_POSE = 1e-8
PACKETS = "bus.ccsds"
PUBLISHED = f"covariances are the published ones ({PACKETS})"


@dataclass(frozen=True)
class Poses:
    """N poses, each an estimate (none is a prediction). Lengths are metres where `metres` is set, else map units."""

    source: str  # name of the file that they are from
    kind: str  # "causal" or "smoothed": each has a T of its own
    time_ns: np.ndarray
    frame: np.ndarray  # index of the frame in the run
    target: np.ndarray  # number of the frame T
    unit: np.ndarray  # number of the scale in force
    metres: np.ndarray
    q_CT: np.ndarray
    p_CT: np.ndarray
    v_C: np.ndarray  # NaN where it is unknown
    w_T: np.ndarray  # NaN where it is unknown
    sigma_att_rad: np.ndarray  # worst axis
    cov_pose: np.ndarray  # [N,6,6] of (phi, dp) in C: R_true = exp(phi) R_CT, p_true = p_CT + dp; NaN where it is unknown
    cov_v: np.ndarray  # [N,3,3]
    begin_ns: int  # stamp of the run's first frame
    usual_interval_ns: int
    frames: int  # of the run, with or without a pose
    covariances_from: str
    camera_turns: bool  # the servicer reported its attitude: rates and velocities are relative to inertial space, not to the camera
    remarks: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.time_ns)

    @property
    def last_target(self) -> int:
        return int(self.target[-1])


_PER_POSE = ("time_ns", "frame", "target", "unit", "metres", "q_CT", "p_CT", "v_C", "w_T", "sigma_att_rad", "cov_pose", "cov_v")


def chosen(poses: Poses, rows: np.ndarray) -> Poses:
    """Those rows alone."""
    return replace(poses, **{name: getattr(poses, name)[rows] for name in _PER_POSE})


def runs_of(poses: Poses, gap_ns: int | None = None) -> list[np.ndarray]:
    """Rows of each run of poses without a gap: one T, no frame without a pose between, no interval longer than gap_ns."""
    longest_ns = gap_ns if gap_ns is not None else int(GAP_INTERVALS * poses.usual_interval_ns)
    broken = (np.diff(poses.frame) != 1) | (np.diff(poses.target) != 0) | (np.diff(poses.time_ns) > longest_ns)
    return np.split(np.arange(len(poses)), np.flatnonzero(broken) + 1)


def with_rates(poses: Poses) -> Poses:
    """Those with an angular velocity, which may stand for one relative to the camera."""
    if poses.camera_turns:
        raise BadInput("--rates: the servicer reported its attitude, so the camera may rotate, and rates relative to it are not known")
    known = np.isfinite(poses.w_T).all(axis=1)
    if not known.any():
        raise BadInput(f"--rates: no pose of {poses.source} has an angular velocity")
    return without(poses, known, "have no angular velocity")


def without(poses: Poses, kept: np.ndarray, why: str) -> Poses:
    """The poses that are kept; says how many are not."""
    left = [] if kept.all() else [f"{int(np.sum(~kept))} of {len(poses)} poses {why}, and are left out"]
    return replace(chosen(poses, np.flatnonzero(kept)), remarks=[*poses.remarks, *left])


def counted(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


def read_poses(folder: pathlib.Path, kind: str) -> Poses:
    """@param kind  "causal": motion.csv, or of a live run its packets; "smoothed": motion_smoothed.csv."""
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such run folder")
    file = folder / MOTION_FILES[kind]
    packets, camera_turns = _packets_of(folder / PACKETS)
    if file.exists():
        poses = _of_table(file, kind, packets if kind == "causal" else [], camera_turns)
    elif packets and kind == "causal":
        poses = _of_packets(folder / PACKETS, packets, camera_turns)
    else:
        raise BadInput(
            f"{folder}: holds no {file.name}"
            + (
                f", and no {PACKETS} with packets of motion"
                if kind == "causal"
                else "; it is of a replay that went to its end: replay the recording of a live run, or leave out --smoothed"
            )
        )
    if not len(poses):
        raise BadInput(f"{folder / poses.source}: none of {poses.frames} frames has a pose: the target was not acquired")
    return poses


def in_metres(poses: Poses, metres_per_unit: float) -> Poses:
    """Lengths in map units become metres by a scale that the user states."""
    units = np.unique(poses.unit[~poses.metres])
    if len(units) == 0:
        raise BadInput(f"--metres-per-unit: all lengths of {poses.source} are in metres already")
    if len(units) > 1:
        raise BadInput(
            f"--metres-per-unit: {poses.source} has {len(units)} map units (scale_number {', '.join(map(str, units))}), which one number can't convert"
        )
    by = np.where(poses.metres, 1.0, metres_per_unit)
    to = np.concatenate([np.ones((len(poses), 3)), np.tile(by[:, None], 3)], axis=1)
    return replace(
        poses,
        p_CT=poses.p_CT * by[:, None],
        v_C=poses.v_C * by[:, None],
        cov_v=poses.cov_v * (by**2)[:, None, None],
        cov_pose=poses.cov_pose * to[:, :, None] * to[:, None, :],
        metres=np.ones(len(poses), dtype=bool),
        remarks=[*poses.remarks, f"lengths are metres by --metres-per-unit {metres_per_unit:g}, whose error is in no covariance"],
    )


def _of_table(file: pathlib.Path, kind: str, packets: list, camera_turns: bool) -> Poses:
    motion = read_motion(file)
    header, rows = read_cells(file)
    cells = dict(zip(header, zip(*rows)))
    # Files of others have no number: then all is in one unit until the scale is known.
    unit = numbers(file, "scale_number", cells["scale_number"]) if "scale_number" in cells else motion.scale_known + 0.0
    target = motion.target_frame if motion.target_frame is not None else np.zeros(len(unit))
    valid = motion.pose_valid
    if not np.isfinite(target[valid]).all():
        raise BadInput(f"{file}: target_frame is empty in a row with a pose")
    cov_pose, cov_v, covariances_from = _covariances(motion, packets, kind)
    at = np.flatnonzero(valid)
    return Poses(
        file.name,
        kind,
        motion.timestamp_ns[at],
        at,
        target[at].astype(int),
        np.nan_to_num(unit[at]).astype(int),
        motion.scale_known[at],
        motion.q_CT[at],
        motion.p_CT[at],
        np.where(motion.velocity_valid[:, None], motion.v_C, np.nan)[at],
        np.where(motion.rate_valid[:, None], motion.w_T, np.nan)[at],
        motion.columns["sigma_att_rad"][at],
        cov_pose[at],
        cov_v[at],
        int(motion.timestamp_ns[0]),
        _usual_interval(motion.timestamp_ns),
        len(valid),
        covariances_from,
        camera_turns,
        _left_out(motion.mode, valid),
    )


def _left_out(modes: list[str], valid: np.ndarray) -> list[str]:
    without, coasted = int(np.sum(~valid)), modes.count("COASTING")
    remarks = [f"{without} of {len(valid)} frames have no pose and are left out"] if without else []
    return remarks + ([f"{coasted} of them are COASTING: predictions, which no image supports"] if coasted else [])


def _usual_interval(time_ns: np.ndarray) -> int:
    return int(np.median(np.diff(time_ns))) if len(time_ns) > 1 else 0


def _covariances(motion: Motion, packets: list, kind: str) -> tuple[np.ndarray, np.ndarray, str]:
    """[N,6,6], [N,3,3], and where they are from."""
    sigma_att, sigma_pos, sigma_vel = (motion.columns[name] for name in ("sigma_att_rad", "sigma_pos", "sigma_vel"))
    variances = np.stack([sigma_att**2] * 3 + [sigma_pos**2] * 3, axis=1)
    cov_pose, cov_v = variances[:, :, None] * np.eye(6), sigma_vel[:, None, None] ** 2 * np.eye(3)
    by_time = {packet.timestamp_ns: packet for packet in packets}
    ours = [by_time.get(int(time_ns)) for time_ns in motion.timestamp_ns]
    agree = all(
        packet is not None and packet.pose_valid and np.abs(packet.q_CT - q).max() < SAME_POSE
        for packet, q, valid in zip(ours, motion.q_CT, motion.pose_valid)
        if valid
    )
    if not packets or not agree:
        why = (
            f"{PACKETS} is not of these poses"
            if packets
            else "none is published with them"
            if kind == "smoothed"
            else f"no {PACKETS} is there"
        )
        return cov_pose, cov_v, f"covariances are the squared sigma of the worst axis, on all axes and without correlations ({why})"
    for row in np.flatnonzero(motion.pose_valid):
        cov_pose[row] = symmetric(ours[row].cov_pose, 6)
        if ours[row].velocity_valid:
            cov_v[row] = symmetric(ours[row].cov_v, 3)
    return cov_pose, cov_v, PUBLISHED


def symmetric(upper: list[float], size: int) -> np.ndarray:
    """A matrix of its upper triangle by rows."""
    matrix = np.zeros((size, size))
    matrix[np.triu_indices(size)] = upper
    return np.triu(matrix) + np.triu(matrix, 1).T


def _packets_of(path: pathlib.Path) -> tuple[list, bool]:
    """The motion packets in order, of which those that begin a map have `begins` set; whether the servicer reported its attitude."""
    from polhode_bus import name_of, open_bus

    if not path.exists() or path.stat().st_size == 0:
        return [], False
    found, camera_turns = [], False
    with open_bus(f"file:{path}") as bus:
        for packet in bus.packets():
            if packet.name == "motion":
                found.append(packet)
                packet.values["begins"] = False
            elif packet.name == "event" and found and name_of(packet, "id") in ("target_acquired", "target_frame_new"):
                found[-1].values["begins"] = True  # the step that a motion packet is the first of
            elif packet.name == "housekeeping":
                camera_turns |= packet.servicer_attitude
    return found, camera_turns


def _of_packets(path: pathlib.Path, packets: list, camera_turns: bool) -> Poses:
    """Of a live run. Packets do not number T: each map that they begin counts as a new one."""
    time_ns = np.array([packet.timestamp_ns for packet in packets], dtype=np.int64)
    if (np.diff(time_ns) <= 0).any():
        at = int(np.argmax(np.diff(time_ns) <= 0)) + 1
        raise BadInput(f"{path}: the stamp of motion packet {at} does not rise: it holds several runs; export a replay of their recordings")
    valid = np.array([packet.pose_valid and packet.mode != "COASTING" for packet in packets], dtype=bool)
    target = np.maximum(np.cumsum([packet.begins for packet in packets]), 1)
    at = np.flatnonzero(valid)
    poses = [packets[row] for row in at]

    def block(name: str, flag: str, empty: np.ndarray, of=np.array) -> np.ndarray:
        return np.array([of(getattr(packet, name)) if getattr(packet, flag) else empty for packet in poses]).reshape(
            len(poses), *empty.shape
        )

    unknown = np.full(3, np.nan)
    q_CT = block("q_CT", "pose_valid", np.full(4, np.nan))
    return Poses(
        path.name,
        "causal",
        time_ns[at],
        at,
        target[at],
        np.array([packet.scale_number for packet in poses], dtype=int),
        np.array([packet.scale_known for packet in poses], dtype=bool),
        q_CT / np.linalg.norm(q_CT, axis=1, keepdims=True),
        block("p_CT", "pose_valid", unknown),
        block("v_C", "velocity_valid", unknown),
        block("w_T_rad_s", "rate_valid", unknown),
        np.array([packet.sigma_att_rad for packet in poses], dtype=float),
        block("cov_pose", "pose_valid", np.full((6, 6), np.nan), lambda upper: symmetric(upper, 6)),
        block("cov_v", "velocity_valid", np.full((3, 3), np.nan), lambda upper: symmetric(upper, 3)),
        int(time_ns[0]),
        _usual_interval(time_ns),
        len(packets),
        PUBLISHED,
        camera_turns,
        _left_out([packet.mode for packet in packets], valid),
    )
