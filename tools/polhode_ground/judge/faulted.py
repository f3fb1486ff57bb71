"""Sets what a replay published beside what was injected into its sequence."""

import pathlib
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from polhode_ground.common.fault_log import LOG_FILE, read_log
from polhode_ground.common.sequence import Sequence
from polhode_ground.judge.aligned import Aligned, align_each
from polhode_ground.judge.run import read_run, read_truth

# The counter that has to tell of each kind of the transform "faults".
COUNTER_OF = {
    "dark": "frames_dark",
    "saturated": "frames_saturated",
    "frozen": "frames_frozen",
    "torn": "frames_torn",
    "bits": "frames_bit_errors",
    "dropped": "frames_missing",
}
# Published sigmas are of the worst axis.
SIGMAS = 3.0


@dataclass
class Verdict:
    """What became of a faulted run."""

    injected: Counter[str] = field(default_factory=Counter)
    counted: Counter[str] = field(default_factory=Counter)
    good_frames: int = 0
    good_with_pose: int = 0
    wrong_poses: list[tuple[int, str, float]] = field(default_factory=list)  # time, kind, error in sigmas

    @property
    def coverage(self) -> float:
        return self.good_with_pose / max(self.good_frames, 1)

    def counter_errors(self) -> dict[str, float]:
        """Relative error of each kind's counter."""
        return {kind: abs(self.counted[kind] - self.injected[kind]) / max(self.injected[kind], 1) for kind in COUNTER_OF}

    def __add__(self, other: "Verdict") -> "Verdict":
        return Verdict(
            self.injected + other.injected,
            self.counted + other.counted,
            self.good_frames + other.good_frames,
            self.good_with_pose + other.good_with_pose,
            self.wrong_poses + other.wrong_poses,
        )


def judge_faulted(run_folder: pathlib.Path, sequence: Sequence, after_first_pose: bool = True) -> Verdict:
    """Coverage of the good frames (from the first pose on, unless told otherwise), poses of bad frames that are wrong by
    more than three published sigmas, and the counters beside the log. @param sequence the faulted one."""
    run, truth, log = read_run(run_folder), read_truth(sequence), read_log(sequence.folder / LOG_FILE)
    kind_at = {one.timestamp_ns: one.kind for one in log}
    motion = run.motions["causal"]
    verdict = Verdict(Counter(one.kind for one in log))
    verdict.counted = Counter({kind: run.summary["counters"][name] for kind, name in COUNTER_OF.items()})
    valid = motion.pose_valid
    first = int(np.argmax(valid)) if valid.any() and after_first_pose else 0
    good = np.array([int(stamp) not in kind_at for stamp in motion.timestamp_ns])
    good[:first] = False
    verdict.good_frames, verdict.good_with_pose = int(good.sum()), int((good & valid).sum())
    for part in align_each(motion, truth):
        verdict.wrong_poses += _wrong_poses(part, kind_at)
    return verdict


def _wrong_poses(aligned: Aligned, kind_at: dict[int, str]) -> list[tuple[int, str, float]]:
    stamps = aligned.estimate.timestamp_ns[aligned.rows_E]
    sigma_rad = aligned.estimate.columns["sigma_att_rad"][aligned.rows_E]
    wrong = []
    for stamp, error, sigma in zip(stamps, aligned.attitude_error_rad, sigma_rad):
        kind = kind_at.get(int(stamp))
        if kind is not None and error > SIGMAS * sigma:
            wrong.append((int(stamp), kind, float(error / sigma)))
    return wrong
