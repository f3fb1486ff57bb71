"""Replays the first frames of a sequence and sets what they predict beside the truth of the rest.

Makes a sequence of the first N frames (its pictures are links), replays it and prints the errors over the horizon.

Examples:
  hil/predict.py SEQ DIR --frames 60
"""

import argparse
import os
import pathlib
import shutil
from typing import TYPE_CHECKING

from polhode_ground.common.ranges import whole
from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main

if TYPE_CHECKING:
    from polhode_ground.common.sequence import Sequence


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder with truth.csv")
    parser.add_argument("out", metavar="DIR", type=pathlib.Path, help="folder for the short sequence and its run")
    parser.add_argument("--frames", type=whole(1), default=200, help="frames to predict from (%(default)s)")
    parser.add_argument("--config", type=pathlib.Path, default=REPOSITORY / "config/default.toml")
    parser.add_argument("--program", type=pathlib.Path, default=REPOSITORY / "build/release/bin/polhode")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="as of polhode replay")
    return parser.parse_args()


# Beside the short sequence: it was made here and may be made anew.
MARKER = ".polhode-predict"


def shorten(sequence: "Sequence", frames: int, out: pathlib.Path) -> pathlib.Path:
    """The sequence with its first frames only; pictures stay where they are."""
    from polhode_ground.common.errors import BadInput
    from polhode_ground.common.whole_file import claim_folder

    source = sequence.folder / "mav0" / "cam0"
    target = out / "mav0" / "cam0"
    try:
        claim_folder(out, MARKER)
        shutil.rmtree(out / "mav0", ignore_errors=True)
        target.mkdir(parents=True)
        rows = [f"{time_ns},{name}" for time_ns, name in zip(sequence.timestamp_ns, sequence.filenames)]
        (target / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows[:frames]]) + "\n", errors="surrogateescape")
        shutil.copy(source / "sensor.yaml", target / "sensor.yaml")
        os.symlink((source / "data").resolve(), target / "data")
        if (sequence.folder / "servicer_attitude.csv").exists():
            shutil.copy(sequence.folder / "servicer_attitude.csv", out)
    except OSError as problem:
        raise BadInput(f"{sequence.folder}: {problem}") from None
    return out


def main() -> int:
    options = arguments()
    from polhode_ground.common.errors import BadInput
    from polhode_ground.common.replay import replay
    from polhode_ground.common.sequence import read_sequence
    from polhode_ground.judge import report
    from polhode_ground.judge.prediction import judge_prediction
    from polhode_ground.judge.run import best_alignment, read_run, read_truth

    sequence = read_sequence(options.sequence)
    truth = read_truth(sequence)
    frames_max = len(sequence.filenames) - 1  # something must be left to be predicted
    if options.frames > frames_max:
        raise BadInput(f"--frames {options.frames}: {options.sequence} has {frames_max + 1} frames, allowed is 1 .. {frames_max}")
    short = shorten(sequence, options.frames, options.out / "sequence")
    replay(short, options.out / "run", options.set, options.config, options.program)
    run = read_run(options.out / "run")
    judged = judge_prediction(run.folder / "motion_model.json", best_alignment(run, truth))
    print(report.prediction_table(judged) or "no prediction: motion_model.json says why")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "predict")
