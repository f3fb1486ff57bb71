"""Judges one output folder of a replay (or of a peer that writes the same files) against one sequence."""

import hashlib
import pathlib
from dataclasses import dataclass

from judge.errors import BadInput
from judge.metrics import Aligned, align_run, judge_motion
from judge.sequence import Sequence, read_json
from judge.shape import judge_shape
from judge.tables import Motion, read_motion

MOTION_FILES = {"causal": "motion.csv", "smoothed": "motion_smoothed.csv"}


@dataclass
class Run:
    """An output folder: its motion files by kind (those that exist) and its summary."""

    folder: pathlib.Path
    motions: dict[str, Motion]
    summary: dict

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


def read_truth(sequence: Sequence, path: pathlib.Path | None = None) -> Motion:
    """The truth of a sequence, or of another file."""
    path = pathlib.Path(path) if path else sequence.truth_path
    if not path.exists():
        raise BadInput(f"{path}: no truth to judge by")
    return read_motion(path)


def best_alignment(run: Run, truth: Motion) -> Aligned | None:
    """The alignment that the run's cloud belongs to: the smoothed trajectory's, else the causal one's."""
    for kind in ("smoothed", "causal"):
        if kind in run.motions:
            aligned = align_run(run.motions[kind], truth)
            if aligned is not None:
                return aligned
    return None


def _flat(value: dict, prefix: str = "") -> dict:
    """Nested dictionary as {'a.b.c': scalar}."""
    result = {}
    for key, inner in value.items():
        if isinstance(inner, dict):
            result |= _flat(inner, f"{prefix}{key}.")
        elif not isinstance(inner, list):
            result[prefix + key] = inner
    return result


def cost(run: Run) -> dict | None:
    """Cost as the run's own summary tells it: every scalar of its timing and memory parts; None without a summary."""
    parts = {key: value for key, value in run.summary.items()
             if any(word in key for word in ("tim", "mem", "cpu", "wall", "heap", "rss", "step"))}
    flat = _flat(parts)
    motion = next(iter(run.motions.values()))
    step_us = motion.columns["step_us"]
    step_us = step_us[step_us == step_us]
    if len(step_us):
        import numpy as np
        flat |= {"step_us.mean": float(step_us.mean()), "step_us.p50": float(np.percentile(step_us, 50)),
                 "step_us.p95": float(np.percentile(step_us, 95)), "step_us.max": float(step_us.max())}
    return flat or None


def _stated_sha256(value) -> str | None:
    """A SHA-256 anywhere under a key of the summary that names one."""
    if not isinstance(value, dict):
        return None
    for key, inner in value.items():
        if "sha256" in key.lower() and isinstance(inner, str) and len(inner) == 64 and "config" not in key.lower():
            return inner.lower()
        found = _stated_sha256(inner)
        if found:
            return found
    return None


def determinism(run: Run) -> dict | None:
    """SHA-256 of bus.ccsds, and whether the summary states the same; None where there is no bus file."""
    path = run.folder / "bus.ccsds"
    if not path.exists():
        return None
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    stated = _stated_sha256(run.summary)
    return {"bus_sha256": digest, "summary_agrees": None if stated is None else stated == digest}


def judge_run(run: Run, sequence: Sequence, truth: Motion) -> dict:
    """The whole report of one run as plain data, ready for JSON."""
    frames_in = len(sequence.timestamp_ns)
    report = {"run": str(run.folder), "sequence": sequence.name,
              "motion": {kind: judge_motion(motion, truth, frames_in) for kind, motion in run.motions.items()}}
    aligned = best_alignment(run, truth)
    report["shape"] = judge_shape(run.folder / "cloud.ply", sequence.model_path, aligned) if aligned else None
    report["cost"] = cost(run)
    report["determinism"] = determinism(run)
    return report
