"""Where the program and its inputs are, and what it leaves behind."""

import csv
import json
import os
import pathlib
import subprocess
import sys

from polhode_ground.common.venv import REPOSITORY

PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
DEFAULTS = REPOSITORY / "config/default.toml"
SAMPLE = REPOSITORY / "hil/data/sample"


def summary(folder: pathlib.Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


def motion_rows(folder: pathlib.Path, name: str = "motion.csv") -> list[dict]:
    with open(folder / name, newline="") as file:
        return list(csv.DictReader(file))


def judged_motion(run, sequence, report) -> dict:
    """What hil/evaluate.py finds of a run, {"causal": ..., "smoothed": ...}. It adds files to the folder of the run, and writes `report`."""
    subprocess.run([sys.executable, REPOSITORY / "hil/evaluate.py", run, sequence, "--json", report], check=True, capture_output=True)
    return json.loads(report.read_text())["runs"][0]["motion"]
