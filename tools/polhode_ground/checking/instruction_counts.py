"""Instructions that a frame costs, stage by stage: a measure of cost that no other load on the machine disturbs.

    tools/instruction_counts.py check     first frames of the sample; fails when a stage costs 10 % more than recorded
    tools/instruction_counts.py record    measures and records (tests/budget/instructions.json)

Counted by callgrind (package valgrind), which takes a minute or two. A stage that became cheaper is named too, so that the
record can follow.
"""

import argparse
import json
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from polhode_ground.common.program import PROGRAM
from polhode_ground.common.venv import REPOSITORY

SAMPLE = REPOSITORY / "hil/data/sample"
RECORD = REPOSITORY / "tests/budget/instructions.json"
FRAMES = 14
TOLERANCE = 0.10
# The function that is a stage; the step holds the others.
STAGES = {
    "step": "polhode::Component::step",
    "image": "polhode::import_frame",
    "mask": "polhode::find_target",
    "features": "polhode::detect_features",
    "tracks": "polhode::add_frame",
    "localise": "polhode::localise_guided",
    "landmarks": "polhode::create_landmarks",
    "jobs": "polhode::run_job",
}


def short_sequence(folder: Path) -> Path:
    """The first frames of the sample."""
    camera = folder / "mav0/cam0"
    (camera / "data").mkdir(parents=True)
    source = SAMPLE / "mav0/cam0"
    lines = (source / "data.csv").read_text().splitlines()[: FRAMES + 1]
    (camera / "data.csv").write_text("\n".join(lines) + "\n")
    shutil.copy(source / "sensor.yaml", camera)
    for line in lines[1:]:
        shutil.copy(source / "data" / line.split(",")[1].strip(), camera / "data")
    return folder


def inclusive_counts(annotation: str) -> dict[str, int]:
    """Instructions below each function from callgrind_annotate's list: "1,234 (5.6%)  file:function(arguments) [object]"."""
    counts: dict[str, int] = {}
    for line in annotation.splitlines():
        found = re.match(r"\s*([\d,]+) \([ \d.]+%\)\s+\S*?:(polhode::[\w:~]+)", line)
        if found:
            count = int(found[1].replace(",", ""))
            counts[found[2]] = max(count, counts.get(found[2], 0))
    return counts


def measure() -> dict[str, float]:
    """Millions of instructions a frame, by stage."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        profile = folder / "callgrind.out"
        subprocess.run(
            [
                "valgrind",
                "--tool=callgrind",
                f"--callgrind-out-file={profile}",
                PROGRAM,
                "replay",
                "--config",
                REPOSITORY / "config/default.toml",
                "--sequence",
                short_sequence(folder / "sequence"),
                "--out",
                folder / "run",
            ],
            check=True,
            capture_output=True,
        )
        annotation = subprocess.run(
            ["callgrind_annotate", "--inclusive=yes", "--threshold=100", profile], check=True, capture_output=True, text=True
        ).stdout
    counts = inclusive_counts(annotation)
    return {stage: round(counts.get(function, 0) / FRAMES / 1e6, 3) for stage, function in STAGES.items()}


def verdicts(recorded: dict[str, float], found: dict[str, float]) -> list[str]:
    """One line for each stage that costs more than it may."""
    return [
        f"{stage}: {found[stage]} million instructions a frame, recorded are {recorded[stage]}"
        for stage in recorded
        if found.get(stage, 0.0) > recorded[stage] * (1 + TOLERANCE) + 0.01
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("check", "record"))
    what = parser.parse_args().what
    found = measure()
    records = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    recorded = records.get(platform.machine(), {})
    for stage, millions in found.items():
        print(f"{stage:<10} {millions:>10.2f} million a frame   recorded {recorded.get(stage, '-')}")
    if what == "record":
        records[platform.machine()] = found
        RECORD.write_text(json.dumps(records, indent=2) + "\n")
        return 0
    wrong = verdicts(recorded, found)
    print("\n".join(wrong))
    return 1 if wrong or not recorded else 0


def command() -> None:
    sys.exit(main())
