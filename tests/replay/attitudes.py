"""Attitudes of rows of motion.csv and truth.csv."""

import numpy


def rotation(row) -> numpy.ndarray:
    """R_CT [3,3]."""
    w, x, y, z = (float(row[f"q_CT_{axis}"]) for axis in "wxyz")
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def mean_rotation(rotations) -> numpy.ndarray:
    u, _, vt = numpy.linalg.svd(sum(rotations))
    return u @ numpy.diag([1.0, 1.0, numpy.linalg.det(u @ vt)]) @ vt


def off_deg(row, truth: dict, R_TT: numpy.ndarray) -> float:
    """How far a row's attitude is from the truth of its time, with R_TT [3,3] from the row's T to the truth's."""
    R = rotation(truth[row["timestamp_ns"]]) @ R_TT @ rotation(row).T
    return float(numpy.degrees(numpy.arccos(numpy.clip((numpy.trace(R) - 1) / 2, -1, 1))))
