"""The motion of a scene at given times, and the files that describe a sequence."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import relative_motion, rigid_body
from .rotations import continuous_signs, quat_conjugate, quat_multiply, quat_to_matrix

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


@dataclass
class Motion:
    """Truth at N times. v_C is the velocity relative to inertial axes, written in C components."""

    time_s: np.ndarray
    q_CT: np.ndarray
    p_CT_m: np.ndarray
    v_C_m_s: np.ndarray
    w_T_rad_s: np.ndarray
    q_IC: np.ndarray

    def R_CT(self, i):
        return quat_to_matrix(self.q_CT[i])


def motion_at(motion, camera_history, times_s):
    """Truth at times_s (ascending, >= 0) of the motion table of a checked scene."""
    q_IC0 = relative_motion.camera_attitude(camera_history, 0.0)
    R_IC0 = quat_to_matrix(q_IC0)
    q_IT0 = quat_multiply(q_IC0, np.asarray(motion["q_CT0"]) / np.linalg.norm(motion["q_CT0"]))
    q_IT, w_T, _ = rigid_body.integrate(q_IT0, np.radians(motion["w0_T_deg_s"]), motion["inertia_kg_m2"], times_s)
    p0_I, v0_I = R_IC0 @ motion["p_CT0_m"], R_IC0 @ motion["v_C0_m_s"]
    q_CT, p_CT, v_C, q_ICs = [], [], [], []
    for i, time_s in enumerate(times_s):
        if motion["translation"] == "hcw":
            R_IH0 = R_IC0 @ quat_to_matrix(motion["q_CH0"])
            p_I, v_I = relative_motion.hill_motion(p0_I, v0_I, R_IH0, motion["mean_motion_rad_s"], time_s)
        else:
            p_I, v_I = relative_motion.constant_velocity(p0_I, v0_I, time_s)
        q_IC = relative_motion.camera_attitude(camera_history, time_s)
        R_CI = quat_to_matrix(q_IC).T
        q_CT.append(quat_multiply(quat_conjugate(q_IC), q_IT[i]))
        p_CT.append(R_CI @ p_I)
        v_C.append(R_CI @ v_I)
        q_ICs.append(q_IC)
    return Motion(np.asarray(times_s), continuous_signs(q_CT), np.array(p_CT), np.array(v_C), w_T, np.array(q_ICs))


def write_truth(path, timestamps_ns, motion):
    """truth.csv: one row per frame, at mid-exposure."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(TRUTH_HEADER)
        for i, stamp in enumerate(timestamps_ns):
            values = np.concatenate([motion.p_CT_m[i], motion.q_CT[i], motion.v_C_m_s[i], motion.w_T_rad_s[i]])
            writer.writerow([int(stamp)] + [repr(float(v)) for v in values])


def write_servicer_attitude(path, timestamps_ns, motion):
    """servicer_attitude.csv: the camera's attitude q_IC at each frame, as the servicer would know it."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["#timestamp_ns", "q_IC_w", "q_IC_x", "q_IC_y", "q_IC_z"])
        for stamp, q_IC in zip(timestamps_ns, motion.q_IC):
            writer.writerow([int(stamp)] + [repr(float(v)) for v in q_IC])


def write_data_csv(path, timestamps_ns):
    rows = [f"{int(s)},{int(s)}.png" for s in timestamps_ns]
    Path(path).write_text("#timestamp [ns],filename\n" + "\n".join(rows) + "\n")


def write_sensor_yaml(path, camera, rate_hz):
    numbers = ", ".join(repr(float(x)) for x in (camera.fu, camera.fv, camera.cu, camera.cv))
    distortion = ", ".join(repr(float(x)) for x in camera.distortion)
    Path(path).write_text(
        "sensor_type: camera\n"
        f"rate_hz: {rate_hz!r}\n"
        f"resolution: [{camera.width}, {camera.height}]\n"
        "camera_model: pinhole\n"
        f"intrinsics: [{numbers}]  # fu, fv, cu, cv [px]; pixel centres at integers\n"
        "distortion_model: radial-tangential\n"
        f"distortion_coefficients: [{distortion}]  # k1, k2, p1, p2\n"
    )


def known_lengths(known, centre_of_mass_G_m, camera, timestamps_ns, motion, project):
    """Known lengths with their pixels in the first frame that shows them well, for a user to give as the scale."""
    out = []
    for item in known:
        ends_T = np.array([item["a_G_m"], item["b_G_m"]]) - centre_of_mass_G_m
        entry = {
            "name": item["name"],
            "length_m": item["length_m"],
            "a_T_m": ends_T[0].tolist(),
            "b_T_m": ends_T[1].tolist(),
        }
        for i, stamp in enumerate(timestamps_ns):
            R_CT = motion.R_CT(i)
            p_C = ends_T @ R_CT.T + motion.p_CT_m[i]
            normal_C = R_CT @ np.asarray(item["normal_G"])
            facing = -np.dot(normal_C, p_C.mean(axis=0)) / np.linalg.norm(p_C.mean(axis=0))
            uv = project(camera, p_C)
            inside = np.all((uv > 2) & (uv < np.array([camera.width, camera.height]) - 3))
            if facing > 0.6 and inside:
                entry.update(frame=i, frame_timestamp_ns=int(stamp), points_px=uv.tolist())
                break
        out.append(entry)
    return out


def write_json(path, value):
    Path(path).write_text(json.dumps(value, indent=1) + "\n")
