"""Judges one output folder of a replay (or of a peer that writes the same files) against one sequence."""

import hashlib
import pathlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import Sequence, read_json
from polhode_ground.common.tables import Motion, read_motion
from polhode_ground.judge.aligned import Aligned, align_last
from polhode_ground.judge.body import judge_body
from polhode_ground.judge.dynamics import judge_dynamics
from polhode_ground.judge.metrics import judge_motion
from polhode_ground.judge.prediction import judge_prediction
from polhode_ground.judge.report import lookup
from polhode_ground.judge.shape import judge_shape
from polhode_ground.judge.truth import Matching, at_frames, estimated_offset

MOTION_FILES = {"causal": "motion.csv", "smoothed": "motion_smoothed.csv"}


@dataclass
class Run:
    """An output folder: its motion files by kind (those that exist) and its summary."""

    folder: pathlib.Path
    motions: dict[str, Motion]
    summary: dict[str, Any]

    @property
    def name(self) -> str:
        return self.folder.resolve().name


def read_run(folder: pathlib.Path) -> Run:
    """Opens an output folder; at least one motion file must be there."""
    folder = pathlib.Path(folder)
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such run folder")
    motions = {kind: read_motion(folder / file) for kind, file in MOTION_FILES.items() if (folder / file).exists()}
    if not motions:
        raise BadInput(f"{folder}: holds neither motion.csv nor motion_smoothed.csv")
    return Run(folder, motions, read_json(folder / "summary.json"))


def read_truth(sequence: Sequence, path: pathlib.Path | None = None, matching: Matching = Matching()) -> Motion:
    """The truth of a sequence at its frames, or that of another file."""
    return at_frames(_read_own(path or sequence.truth_path), sequence.timestamp_ns, matching)


def read_truth_for(run: Run, frames_ns: np.ndarray, path: pathlib.Path, asked: Matching) -> Motion:
    """The truth at the frames; its clock's offset is estimated from the run where it is asked for."""
    own = _read_own(path)
    if asked.offset_s is None:
        asked = estimated_offset(run.motions.get("smoothed") or run.motions["causal"], own, asked.gap_max_s)
    return at_frames(own, frames_ns, asked)


def _read_own(path: pathlib.Path) -> Motion:
    """With the rows that its file has."""
    path = pathlib.Path(path)
    if not path.exists():
        raise BadInput(f"{path}: no truth to judge by")
    return read_motion(path)


def best_alignment(run: Run, truth: Motion) -> Aligned | None:
    """The alignment that the run's cloud belongs to: the smoothed trajectory's, else the causal one's."""
    for kind in ("smoothed", "causal"):
        if kind in run.motions:
            aligned = align_last(run.motions[kind], truth)
            if aligned is not None:
                return aligned
    return None


def _number(summary: dict[str, Any], path: str) -> float | None:
    """A number at 'a.b.c' of the summary; None where it is not there."""
    value = lookup(summary, path)
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def cost(run: Run) -> dict[str, Any] | None:
    """Cost per frame and memory as the run's own summary tells them; None where it tells nothing.

    Step times come from motion.csv where the summary has none. cpu_total_* counts the work after the last frame too,
    which is what an offline system's total is to be set beside.
    """
    summary = run.summary
    frames = _number(summary, "frames.in")
    cpu_s, wall_s = _number(summary, "cost.cpu_s"), _number(summary, "cost.wall_s")
    finish_s = _number(summary, "cost.finish_cpu_s") or 0.0
    octets = _number(summary, "memory.peak_resident_octets")
    step_us = next(iter(run.motions.values())).columns["step_us"]
    step_us = step_us[np.isfinite(step_us)]
    result = {
        "cpu_per_frame_ms": 1e3 * cpu_s / frames if cpu_s is not None and frames else None,
        "cpu_total_per_frame_ms": 1e3 * (cpu_s + finish_s) / frames if cpu_s is not None and frames else None,
        "wall_per_frame_ms": 1e3 * wall_s / frames if wall_s is not None and frames else None,
        "peak_resident_mb": octets / 1e6 if octets else None,
    }
    for name, percent in (("p50", 50), ("p95", 95), ("p99", 99), ("max", 100)):
        stated_us = _number(summary, f"timings.step.{name}_us")
        measured_us = float(np.percentile(step_us, percent)) if len(step_us) else None
        value_us = stated_us if stated_us is not None else measured_us
        result[f"step_{name}_ms"] = value_us / 1e3 if value_us is not None else None
    return result if any(value is not None for value in result.values()) else None


def determinism(run: Run) -> dict[str, Any] | None:
    """SHA-256 of bus.ccsds, and whether the summary states the same; None where there is no bus file."""
    path = run.folder / "bus.ccsds"
    if not path.exists():
        return None
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    stated = lookup(run.summary, "bus.sha256")
    return {"bus_sha256": digest, "summary_agrees": None if stated is None else stated == digest}


def judge_run(run: Run, sequence: Sequence, truth: Motion) -> dict[str, Any]:
    """The whole report of one run as plain data, ready for JSON."""
    frames_in = len(sequence.timestamp_ns)
    report: dict[str, Any] = {
        "run": str(run.folder),
        "sequence": sequence.name,
        "truth": truth.remark,
        "motion": {kind: judge_motion(motion, truth, frames_in) for kind, motion in run.motions.items()},
    }
    aligned = best_alignment(run, truth)
    report["shape"] = judge_shape(run.folder / "cloud.ply", sequence.model_path, aligned) if aligned else None
    scene = read_json(sequence.model_path.parent / "scene.json")
    report["body"] = judge_body(run.folder, sequence.model_path, scene, aligned) if aligned else None
    report["dynamics"] = judge_dynamics(run.folder / "motion_model.json", scene, aligned)
    report["prediction"] = judge_prediction(run.folder / "motion_model.json", aligned)
    report["cost"] = cost(run)
    report["determinism"] = determinism(run)
    return report
