"""Made-up trajectories of a tumbling body with exact truth, and output folders with errors of known size."""

import csv
import json
import pathlib
from dataclasses import dataclass, field

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

TRUTH_HEADER = [
    "timestamp_ns",
    "p_CT_x",
    "p_CT_y",
    "p_CT_z",
    "q_CT_w",
    "q_CT_x",
    "q_CT_y",
    "q_CT_z",
    "v_C_x",
    "v_C_y",
    "v_C_z",
    "w_T_x",
    "w_T_y",
    "w_T_z",
]
MOTION_HEADER = [
    "frame",
    "timestamp_ns",
    "mode",
    "pose_valid",
    "rate_valid",
    "velocity_valid",
    "scale_known",
    "q_CT_w",
    "q_CT_x",
    "q_CT_y",
    "q_CT_z",
    "p_CT_x",
    "p_CT_y",
    "p_CT_z",
    "v_C_x",
    "v_C_y",
    "v_C_z",
    "w_T_x",
    "w_T_y",
    "w_T_z",
    "sigma_att_rad",
    "sigma_pos",
    "sigma_vel",
    "sigma_rate_rad_s",
    "features",
    "matches",
    "inliers",
    "landmarks",
    "keyframes",
    "step_us",
    "target_frame",
]
START_NS = 1_700_000_000_000_000_000
WIDTH_PX, HEIGHT_PX, FOCAL_PX = 320, 240, 500.0
BOX_M = np.array([0.6, 0.4, 1.0])


@dataclass
class Body:
    """N frames of a torque-free axisymmetric body, exact by its closed form."""

    time_s: np.ndarray
    R_CT: Rotation
    p_CT: np.ndarray
    v_C: np.ndarray
    w_T: np.ndarray

    @property
    def timestamp_ns(self) -> np.ndarray:
        return START_NS + np.round(self.time_s * 1e9).astype(np.int64)


def tumbling_body(frames: int = 120, step_s: float = 1.0, velocity_m_s=(0.001, 0.0, -0.01), turning: bool = True) -> Body:
    """Inertia ratio 0.5 (transverse / axial - 1 fixed), nutating about z; rates about 2 deg/s, range 8 m.

    w_x, w_y turn with angular frequency lambda = (1 - J_z / J_x) * w_z; attitude by exact steps of R' = R [w]x with the
    momentum fixed: R(t) = exp(h t) R0 exp(-lambda z t), h = momentum / J_x in C.
    """
    time_s = np.arange(frames) * step_s
    if not turning:
        R_CT = Rotation.concatenate([Rotation.from_rotvec([0.4, 0.2, 0.1])] * frames)
        w_T = np.zeros((frames, 3))
    else:
        w0 = np.radians([1.2, 0.0, 2.0])
        ratio = 0.4  # J_z / J_x
        slip = (1 - ratio) * w0[2]
        R0 = Rotation.from_rotvec([0.9, -0.4, 0.3])
        h_C = R0.apply([w0[0], w0[1], ratio * w0[2]])
        R_CT = Rotation.from_rotvec(np.outer(time_s, h_C)) * R0 * Rotation.from_rotvec(np.outer(time_s, [0, 0, slip]))
        w_T = np.stack([w0[0] * np.cos(slip * time_s), -w0[0] * np.sin(slip * time_s), np.full(frames, w0[2])], axis=1)
    v_C = np.tile(np.asarray(velocity_m_s, dtype=float), (frames, 1))
    return Body(time_s, R_CT, np.array([0.2, -0.1, 8.0]) + v_C * time_s[:, None], v_C, w_T)


@dataclass
class Errors:
    """What an estimate does wrong; the defaults are a perfect run in a body frame of its own."""

    attitude_rms_rad: float = 0.0
    position_rms_m: float = 0.0
    rate_rms_rad_s: float = 0.0
    velocity_rms_m_s: float = 0.0
    scale: float = 1.0
    R_ET: Rotation = field(default_factory=lambda: Rotation.from_rotvec([0.5, -1.1, 0.7]))
    offset_E_m: tuple = (0.03, -0.02, 0.05)  # the truth's origin in the estimate's frame
    scale_known: bool = True
    twin: bool = False
    first_frame: int = 0
    seed: int = 7


def _directions(random, count: int) -> np.ndarray:
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def estimate_of(body: Body, errors: Errors) -> dict[str, np.ndarray]:
    """Arrays q_CT, p_CT, v_C, w_T of a run with these errors; every error vector has its stated length exactly."""
    random = np.random.default_rng(errors.seed)
    count = len(body.time_s)
    R_CT, w_T = body.R_CT, body.w_T
    if errors.twin:
        mirror = np.diag([1.0, 1.0, -1.0])
        R_CT = Rotation.from_matrix(mirror @ R_CT.as_matrix() @ mirror)
        w_T = -(w_T @ mirror)
    R_CE = Rotation.from_rotvec(errors.attitude_rms_rad * _directions(random, count)) * R_CT * errors.R_ET.inv()
    p_CE = body.p_CT - R_CE.apply(errors.offset_E_m) + errors.position_rms_m * _directions(random, count)
    w_E = errors.R_ET.apply(w_T)
    v_C = body.v_C - R_CE.apply(np.cross(w_E, errors.offset_E_m))
    w_E = w_E + errors.rate_rms_rad_s * _directions(random, count)
    v_C = v_C + errors.velocity_rms_m_s * _directions(random, count)
    return {"q_CT": R_CE.as_quat(scalar_first=True), "p_CT": errors.scale * p_CE, "v_C": errors.scale * v_C, "w_T": w_E}


def write_motion(path: pathlib.Path, body: Body, errors: Errors) -> None:
    """One motion file; rows before errors.first_frame have no pose."""
    values = estimate_of(body, errors)
    random = np.random.default_rng(errors.seed)
    sigmas = [
        x / np.sqrt(3) if x else ""
        for x in (errors.attitude_rms_rad, errors.scale * errors.position_rms_m, errors.velocity_rms_m_s, errors.rate_rms_rad_s)
    ]
    with open(path, "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(MOTION_HEADER)
        for i in range(len(body.time_s)):
            known = i >= errors.first_frame
            row = [*values["q_CT"][i], *values["p_CT"][i], *values["v_C"][i], *values["w_T"][i], *sigmas]
            features = 150 + 3 * i // 4 + int(random.integers(20))
            writer.writerow(
                [
                    i,
                    body.timestamp_ns[i],
                    "TRACKING" if known else "ACQUIRING",
                    *([int(known)] * 3),
                    int(known and errors.scale_known),
                    *(row if known else [""] * len(row)),
                    features,
                    features * 3 // 4,
                    features * 2 // 3 if known else 0,
                    400 + i if known else 0,
                    1 + i // 6,
                    9000 + 40 * i,
                    1 if known else "",
                ]
            )


def box_points(count: int, seed: int = 3) -> np.ndarray:
    """Points [N,3] spread over the faces of the box that model.ply holds [m]."""
    random = np.random.default_rng(seed)
    points = random.uniform(-0.5, 0.5, size=(count, 3))
    axis = random.integers(3, size=count)
    points[np.arange(count), axis] = 0.5 * random.choice([-1, 1], size=count)
    return points * BOX_M


def write_ply(path: pathlib.Path, points: np.ndarray, faces=()) -> None:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property float {a}" for a in "xyz")]
    if len(faces):
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    lines += ["end_header", *(" ".join(f"{x:.6f}" for x in point) for point in points)]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n")


def _write_model(path: pathlib.Path) -> None:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * BOX_M
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    write_ply(path, corners, [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])


def project(p_C: np.ndarray) -> np.ndarray:
    """Pixels [N,2] of the made-up camera, which has no distortion."""
    return FOCAL_PX * p_C[:, :2] / p_C[:, 2:] + [(WIDTH_PX - 1) / 2, (HEIGHT_PX - 1) / 2]


def write_sequence(folder: pathlib.Path, body: Body, rates: bool = True) -> pathlib.Path:
    """SEQ with frames (dots where the box's points are), camera, truth and mesh."""
    cam0 = folder / "mav0" / "cam0"
    (cam0 / "data").mkdir(parents=True)
    (cam0 / "sensor.yaml").write_text(
        f"sensor_type: camera\nrate_hz: 1\nresolution: [{WIDTH_PX}, {HEIGHT_PX}]\ncamera_model: pinhole\n"
        f"intrinsics: [{FOCAL_PX}, {FOCAL_PX}, {(WIDTH_PX - 1) / 2}, {(HEIGHT_PX - 1) / 2}]\n"
        "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n"
    )
    points_T = box_points(400)
    with open(cam0 / "data.csv", "w") as stream:
        stream.write("#timestamp [ns],filename\n")
        for i, timestamp_ns in enumerate(body.timestamp_ns):
            stream.write(f"{timestamp_ns},{timestamp_ns}.png\n")
            picture = np.full((HEIGHT_PX, WIDTH_PX), 8, dtype=np.uint8)
            column, row = np.round(project(body.R_CT[i].apply(points_T) + body.p_CT[i])).astype(int).T
            picture[row.clip(0, HEIGHT_PX - 1), column.clip(0, WIDTH_PX - 1)] = 200
            Image.fromarray(picture).save(cam0 / "data" / f"{timestamp_ns}.png")
    with open(folder / "truth.csv", "w", newline="") as stream:
        writer = csv.writer(stream)
        q_CT = body.R_CT.as_quat(scalar_first=True)
        writer.writerow(TRUTH_HEADER if rates else TRUTH_HEADER[:8])
        for i, timestamp_ns in enumerate(body.timestamp_ns):
            row = [timestamp_ns, *body.p_CT[i], *q_CT[i]]
            writer.writerow([*row, *body.v_C[i], *body.w_T[i]] if rates else row)
    _write_model(folder / "model.ply")
    return folder


def write_acquired(folder: pathlib.Path, frames: int) -> tuple[pathlib.Path, pathlib.Path]:
    """(sequence, run) of a short tumbling body that is acquired on its third frame, with honest sigmas."""
    body = tumbling_body(frames=frames)
    sequence = write_sequence(folder / "seq", body)
    errors = Errors(attitude_rms_rad=0.01, position_rms_m=0.02, rate_rms_rad_s=0.001, velocity_rms_m_s=0.001, first_frame=3)
    return sequence, write_run(folder / "run", body, errors, sequence=sequence)


def write_run(
    folder: pathlib.Path, body: Body, causal: Errors, smoothed: Errors | None = None, sequence: pathlib.Path | None = None
) -> pathlib.Path:
    """An output folder of a replay with these errors, cloud and observations included."""
    folder.mkdir(parents=True)
    smoothed = smoothed or causal
    write_motion(folder / "motion.csv", body, causal)
    write_motion(folder / "motion_smoothed.csv", body, smoothed)
    points_T = box_points(600)
    write_ply(folder / "cloud.ply", smoothed.scale * (smoothed.R_ET.apply(points_T) + smoothed.offset_E_m))
    (folder / "bus.ccsds").write_bytes(b"\x08\x01" * 100)
    (folder / "summary.json").write_text(
        json.dumps(
            {
                "version": "0",
                "sequence": str(sequence or ""),
                "frames": {"in": len(body.time_s)},
                "cost": {"cpu_s": 0.01 * len(body.time_s), "wall_s": 0.02 * len(body.time_s), "finish_cpu_s": 0.5},
                "memory": {"peak_resident_octets": 50_000_000},
                "timings": {"step": {"p50_us": 9000, "max_us": 12000}},
            }
        )
    )
    random = np.random.default_rng(1)
    with open(folder / "observations.csv", "w") as stream:
        stream.write("frame,timestamp_ns,landmark,u_px,v_px,predicted_u_px,predicted_v_px,inlier\n")
        for i in range(len(body.time_s)):
            predicted = project(body.R_CT[i].apply(box_points(60)) + body.p_CT[i])
            for landmark, (u, v) in enumerate(predicted if i >= causal.first_frame else []):
                du, dv = random.normal(0, 0.5 if landmark % 10 else 6, 2)
                cells = f"{landmark},{u + du:.2f},{v + dv:.2f},{u:.2f},{v:.2f},{int(landmark % 10 > 0)}"
                stream.write(f"{i},{body.timestamp_ns[i]},{cells}\n")
            for u, v in random.uniform([100, 80], [220, 160], (8, 2)):
                stream.write(f"{i},{body.timestamp_ns[i]},,{u:.2f},{v:.2f},,,0\n")
    return folder
