"""An estimate laid over the truth: one constant rotation and one similarity for each target frame T.

A run that begins its map anew after a loss goes on in another T, with axes, origin and unit of its own: nothing ties its
poses to those before. So each T is aligned by itself, over the frames whose poses are in it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from polhode_ground.common.tables import Motion, in_frame, join, target_frames
from polhode_ground.judge import align


@dataclass
class Aligned:
    """The frames [N] that both files have with a valid pose in one T, and the constant freedoms between them."""

    target_frame: int
    estimate: Motion  # its values are valid in this T's frames only
    truth: Motion
    rows_E: np.ndarray
    rows_T: np.ndarray
    R_CE: Rotation
    R_CT: Rotation
    R_ET: Rotation
    similarity: align.Similarity
    one_unit: np.ndarray  # [N] the frames whose lengths share one unit; those of the others are not judged
    metric: bool  # that unit is the metre

    @property
    def attitude_error_rad(self) -> np.ndarray:
        return align.angles_rad(self.R_CE * self.R_ET, self.R_CT)

    @property
    def position_error_m(self) -> np.ndarray:
        """[N] after the similarity; NaN in frames of another unit."""
        return self._position_error_m(self.similarity)

    @cached_property
    def own_similarity(self) -> align.Similarity:
        """What a run says in metres keeps its own, since its sigmas hold the error of its scale; one that claims no scale has it fitted."""
        if not self.metric:
            return self.similarity
        return _align_lengths(self.estimate, self.truth, self.rows_E, self.rows_T, self.one_unit, False)

    @property
    def own_position_error_m(self) -> np.ndarray:
        """[N] after own_similarity; NaN in frames of another unit."""
        return self._position_error_m(self.own_similarity)

    def _position_error_m(self, similarity: align.Similarity) -> np.ndarray:
        moved = align.apply_similarity(similarity, self.R_CE, self.estimate.p_CT[self.rows_E])
        return np.where(self.one_unit, np.linalg.norm(moved - self.truth.p_CT[self.rows_T], axis=1), np.nan)

    @property
    def range_m(self) -> np.ndarray:
        return np.asarray(np.linalg.norm(self.truth.p_CT[self.rows_T], axis=1))


def _align_lengths(
    estimate: Motion, truth: Motion, rows_E: np.ndarray, rows_T: np.ndarray, one_unit: np.ndarray, fit_scale: bool = True
) -> align.Similarity:
    kept_E, kept_T = rows_E[one_unit], rows_T[one_unit]
    return align.align_positions(align.rotations(estimate.q_CT[kept_E]), estimate.p_CT[kept_E], truth.p_CT[kept_T], fit_scale)


def _align_one(number: int, estimate: Motion, truth: Motion) -> Aligned | None:
    """None where fewer than two frames have a pose in both.

    A run that learns its scale on the way has rows in map units before and in metres after: those in metres are judged.
    """
    rows_E, rows_T = join(estimate, truth)
    both = estimate.pose_valid[rows_E] & truth.pose_valid[rows_T]
    rows_E, rows_T = rows_E[both], rows_T[both]
    if len(rows_E) < 2:
        return None
    R_CE, R_CT = align.rotations(estimate.q_CT[rows_E]), align.rotations(truth.q_CT[rows_T])
    known = estimate.scale_known[rows_E]
    metric = int(known.sum()) >= 2
    one_unit = known if metric else ~known
    return Aligned(
        number,
        estimate,
        truth,
        rows_E,
        rows_T,
        R_CE,
        R_CT,
        align.align_rotation(R_CE, R_CT),
        _align_lengths(estimate, truth, rows_E, rows_T, one_unit),
        one_unit,
        metric,
    )


def align_each(estimate: Motion, truth: Motion) -> list[Aligned]:
    """An alignment for each T with at least two poses, in order of their numbers; empty where there is none."""
    found = [_align_one(number, in_frame(estimate, number), truth) for number in target_frames(estimate)]
    return [one for one in found if one is not None]


def align_last(estimate: Motion, truth: Motion) -> Aligned | None:
    """The alignment of the last T, which the run's cloud and motion model are in."""
    parts = align_each(estimate, truth)
    return parts[-1] if parts else None
