"""Quaternions and rotation matrices. Hamilton, (w, x, y, z), unit norm; R_AB takes B components to A."""

import numpy as np


def quat_multiply(q_AB, q_BC):
    """q_AC = q_AB * q_BC for quaternions of shape (4,)."""
    w1, x1, y1, z1 = q_AB
    w2, x2, y2, z2 = q_BC
    return np.array(
        [
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        ]
    )


def quat_conjugate(q_AB):
    """q_BA."""
    w, x, y, z = q_AB
    return np.array([w, -x, -y, -z])


def quat_to_matrix(q_AB):
    """R_AB, shape (3, 3)."""
    w, x, y, z = np.asarray(q_AB, dtype=float) / np.linalg.norm(q_AB)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quat_from_axis_angle(axis, angle_rad):
    """Rotation by angle_rad about a unit or non-unit axis (3,)."""
    axis = np.asarray(axis, dtype=float)
    axis = axis / np.linalg.norm(axis)
    return np.concatenate([[np.cos(angle_rad / 2)], np.sin(angle_rad / 2) * axis])


def quat_slerp(q_0, q_1, fraction):
    """Spherical interpolation by the shorter way, fraction in [0, 1]."""
    q_0, q_1 = np.asarray(q_0, dtype=float), np.asarray(q_1, dtype=float)
    cosine = float(np.dot(q_0, q_1))
    if cosine < 0:
        q_1, cosine = -q_1, -cosine
    if cosine > 1 - 1e-12:
        q = q_0 + fraction * (q_1 - q_0)
        return q / np.linalg.norm(q)
    angle = np.arccos(cosine)
    return (np.sin((1 - fraction) * angle) * q_0 + np.sin(fraction * angle) * q_1) / np.sin(angle)


def continuous_signs(quaternions):
    """The same rotations, (N, 4), with signs chosen so that the sequence is continuous and starts with w >= 0."""
    out = np.array(quaternions, dtype=float)
    if out[0, 0] < 0:
        out[0] = -out[0]
    for i in range(1, len(out)):
        if np.dot(out[i], out[i - 1]) < 0:
            out[i] = -out[i]
    return out
