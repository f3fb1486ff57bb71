"""Trajectories as the field's tools read them: `timestamp_s tx ty tz qx qy qz qw`, the camera in the target's frame T."""

import numpy as np

from polhode_ground.common.tables import Motion
from polhode_ground.judge import align

SECOND_NS = 1_000_000_000


def tum_text(motion: Motion) -> str:
    """One line a row with a pose: position of C in T and rotation q_TC; times keep all of their nanoseconds."""
    rows = np.flatnonzero(motion.pose_valid)
    if len(rows) == 0:
        return ""
    R_TC = align.rotations(motion.q_CT[rows]).inv()
    lines = []
    for time_ns, p_TC, q_TC in zip(motion.timestamp_ns[rows], -R_TC.apply(motion.p_CT[rows]), R_TC.as_quat()):
        numbers = " ".join(f"{value:.9g}" for value in (*p_TC, *q_TC))
        lines.append(f"{time_ns // SECOND_NS}.{time_ns % SECOND_NS:09d} {numbers}\n")
    return "".join(lines)
