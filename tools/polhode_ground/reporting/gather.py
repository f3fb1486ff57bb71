"""Everything that a run's page is made of; what a run does not have is empty or None."""

import pathlib
from dataclasses import dataclass, field

from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import Sequence, read_json, read_sequence
from polhode_ground.common.tables import Motion, join
from polhode_ground.judge.run import Run, judge_run, read_run, read_truth_for
from polhode_ground.judge.truth import Matching
from polhode_ground.plots import series


@dataclass
class Material:
    run: Run
    model: dict  # motion_model.json
    shape: dict  # shape.json
    events: list
    sequence: Sequence | None = None
    truth: Motion | None = None
    judged: dict | None = None  # the judge's report, with truth
    sensor: dict = field(default_factory=dict)  # sensor.yaml as texts
    imported: dict = field(default_factory=dict)  # import.json of the sequence
    remarks: list[str] = field(default_factory=list)  # what could not be read


def _sequence_of(run: Run, asked: pathlib.Path | None, remarks: list[str]) -> Sequence | None:
    if asked is not None:
        return read_sequence(asked)
    named = run.summary.get("sequence")
    try:
        if isinstance(named, str) and named:
            return read_sequence(pathlib.Path(named))
        remarks.append("summary.json names no sequence: no frames are shown; give --sequence")
    except BadInput as problem:
        remarks.append(f"The sequence can't be read, so no frames are shown ({problem}); give --sequence")
    return None


def _truth_of(run: Run, sequence: Sequence | None, asked: pathlib.Path | None, matching: Matching, remarks: list[str]) -> Motion | None:
    path = asked or (sequence.truth_path if sequence and sequence.truth_path.exists() else None)
    if path is None:
        return None
    frames_ns = sequence.timestamp_ns if sequence else next(iter(run.motions.values())).timestamp_ns
    try:
        truth = read_truth_for(run, frames_ns, path, matching)
        for motion in run.motions.values():
            join(motion, truth)
        return truth
    except BadInput as problem:
        if asked is not None:
            raise
        remarks.append(f"The truth is left out: {problem}")
        return None


def gather(
    folder: pathlib.Path, sequence: pathlib.Path | None = None, truth: pathlib.Path | None = None, matching: Matching = Matching()
) -> Material:
    run, remarks = read_run(folder), []
    found = _sequence_of(run, sequence, remarks)
    material = Material(
        run,
        read_json(folder / "motion_model.json"),
        read_json(folder / "shape.json"),
        series.events_of(folder),
        found,
        _truth_of(run, found, truth, matching, remarks),
        remarks=remarks,
    )
    if found is not None:
        found.see_as(run.summary)
        material.sensor = found.fields
        material.imported = read_json(found.folder / "import.json")
    if material.truth is not None and found is not None:
        material.judged = judge_run(run, found, material.truth)
    return material
