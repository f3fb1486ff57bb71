"""Attitudes of rows of motion.csv and truth.csv."""

import numpy
from scipy.spatial.transform import Rotation


def rotation(row) -> numpy.ndarray:
    """R_CT [3,3]."""
    return Rotation.from_quat([float(row[f"q_CT_{axis}"]) for axis in "wxyz"], scalar_first=True).as_matrix()


def mean_rotation(rotations) -> numpy.ndarray:
    return Rotation.from_matrix(numpy.array(list(rotations))).mean().as_matrix()


def off_deg(row, truth: dict, R_TT: numpy.ndarray) -> float:
    """How far a row's attitude is from the truth of its time, with R_TT [3,3] from the row's T to the truth's."""
    R = rotation(truth[row["timestamp_ns"]]) @ R_TT @ rotation(row).T
    return float(numpy.degrees(Rotation.from_matrix(R).magnitude()))
