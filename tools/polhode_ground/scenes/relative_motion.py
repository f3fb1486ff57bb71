"""Where the target is: constant velocity or Hill-Clohessy-Wiltshire, seen by a fixed or turning camera.

Frames: I inertial with axes equal to the camera's at time 0 and origin at the camera; C camera; H Hill
(x radial outward, y along track, z orbit normal), turning about z_H with the mean motion.
"""

import numpy as np

from .rotations import quat_from_axis_angle, quat_multiply, quat_slerp, quat_to_matrix


def constant_velocity(p0_I_m, v_I_m_s, time_s):
    """Position and velocity in I after time_s. Each (3,)."""
    return np.asarray(p0_I_m) + time_s * np.asarray(v_I_m_s), np.array(v_I_m_s, dtype=float)


def hill_state(p0_H_m, v0_H_m_s, mean_motion_rad_s, time_s):
    """Closed solution of the Hill-Clohessy-Wiltshire equations. v is relative to the turning axes of H."""
    n, t = mean_motion_rad_s, time_s
    s, c = np.sin(n * t), np.cos(n * t)
    x0, y0, z0 = p0_H_m
    vx0, vy0, vz0 = v0_H_m_s
    p_H = np.array(
        [
            (4 - 3 * c) * x0 + s / n * vx0 + 2 / n * (1 - c) * vy0,
            6 * (s - n * t) * x0 + y0 - 2 / n * (1 - c) * vx0 + (4 * s - 3 * n * t) / n * vy0,
            c * z0 + s / n * vz0,
        ]
    )
    v_H = np.array(
        [
            3 * n * s * x0 + c * vx0 + 2 * s * vy0,
            -6 * n * (1 - c) * x0 - 2 * s * vx0 + (4 * c - 3) * vy0,
            -n * s * z0 + c * vz0,
        ]
    )
    return p_H, v_H


def hill_motion(p0_I_m, v0_I_m_s, R_IH0, mean_motion_rad_s, time_s):
    """Position and inertial velocity in I after time_s, for a camera on a circular orbit."""
    n_H = np.array([0.0, 0.0, mean_motion_rad_s])
    p0_H = R_IH0.T @ np.asarray(p0_I_m)
    v0_H = R_IH0.T @ np.asarray(v0_I_m_s) - np.cross(n_H, p0_H)
    p_H, v_H = hill_state(p0_H, v0_H, mean_motion_rad_s, time_s)
    turn = quat_to_matrix(quat_from_axis_angle([0, 0, 1], mean_motion_rad_s * time_s))
    R_IH = R_IH0 @ turn
    return R_IH @ p_H, R_IH @ (v_H + np.cross(n_H, p_H))


def camera_attitude(history, time_s):
    """q_IC at time_s from rows [t_s, w, x, y, z] (q_IC), interpolated; held before the first and after the last."""
    if not history:
        return np.array([1.0, 0.0, 0.0, 0.0])
    times = [row[0] for row in history]
    if time_s <= times[0]:
        return np.asarray(history[0][1:], dtype=float)
    if time_s >= times[-1]:
        return np.asarray(history[-1][1:], dtype=float)
    i = int(np.searchsorted(times, time_s, side="right")) - 1
    fraction = (time_s - times[i]) / (times[i + 1] - times[i])
    return quat_slerp(history[i][1:], history[i + 1][1:], fraction)


def turning_history(q_IC0, w_C_rad_s, times_s):
    """Rows [t_s, w, x, y, z] of a camera that turns with a constant rate w_C_rad_s (3,)."""
    rate = np.linalg.norm(w_C_rad_s)
    rows = []
    for time_s in times_s:
        q = np.asarray(q_IC0, dtype=float)
        if rate > 0:
            q = quat_multiply(q, quat_from_axis_angle(w_C_rad_s, rate * time_s))
        rows.append([float(time_s), *q])
    return rows
