"""Judges replay outputs against a sequence's truth, side by side.

Prints one table: coverage, attitude, position, angular velocity and its periods, linear velocity, shape, consistency of
the published sigmas, cost; and says which runs follow the depth-reversed twin of the truth. motion.csv ("causal", what
flies) and motion_smoothed.csv ("smoothed", to set beside offline systems) are both judged, after one constant rotation
for attitude and one scale and offset for positions. Writes RUN/truth.tum, for tools that read trajectories (docs/trajectories.md).

Examples:
  hil/evaluate.py DIR SEQ
  hil/evaluate.py DIR SEQ --vs OTHER_DIR --json report.json
  hil/evaluate.py DIR SEQ --plots FOLDER
"""

import argparse
import json
import pathlib
import sys
from typing import TYPE_CHECKING, Any

from polhode_ground.common.venv import enter_venv, run_main

if TYPE_CHECKING:
    from polhode_ground.common.tables import Motion
    from polhode_ground.judge.run import Run


def arguments() -> argparse.Namespace:
    from polhode_ground.judge.truth_options import add_truth_options

    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Sigmas are taken as one sigma of the worst axis: 95 % of the error norms should lie within 2.80.\n"
        "Exit status: 0 judged, 2 unusable input (one line on stderr says which).",
    )
    parser.add_argument("run", metavar="RUN", type=pathlib.Path, help="output folder of a replay")
    parser.add_argument("sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder with truth.csv")
    parser.add_argument(
        "--vs", metavar="RUN2", type=pathlib.Path, nargs="+", default=[], help="more runs of the same sequence, set beside the first"
    )
    add_truth_options(parser, "truth instead of SEQ/truth.csv")
    parser.add_argument("--json", metavar="FILE", type=pathlib.Path, help="write the reports of all runs as JSON")
    parser.add_argument("--plots", metavar="DIR", type=pathlib.Path, help="write PNGs of each run's errors into DIR")
    return parser.parse_args()


def write_json(path: pathlib.Path, reports: list[dict[str, Any]]) -> None:
    from polhode_ground.common.errors import BadInput
    from polhode_ground.common.whole_file import MARK, write_whole

    try:
        write_whole(path, json.dumps({"note": MARK, "runs": reports}, indent=2, default=lambda value: value.item()) + "\n")
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None


def write_plots(folder: pathlib.Path, runs: list["Run"], truth: "Motion") -> None:
    from polhode_ground.plots import errors, motion, style

    style.prepare(folder)
    for run in runs:
        for path in (*motion.draw(run, truth, folder, prefix=f"{run.name}_"), *errors.draw(run, truth, folder, prefix=f"{run.name}_")):
            print(path)


def write_truth(folder: pathlib.Path, truth: "Motion") -> None:
    """RUN/truth.tum beside the run's causal.tum and smoothed.tum; a remark where RUN may not be written to, or holds another's."""
    from polhode_ground.common.whole_file import REPLAY_MARK, write_whole
    from polhode_ground.judge.trajectory import tum_text

    path, text = folder / "truth.tum", tum_text(truth)
    try:
        if (folder / REPLAY_MARK).exists() or not path.exists():
            write_whole(path, text, ours=True)
        elif path.read_bytes() != text.encode():
            print(f"evaluate: {path}: is there already, left alone", file=sys.stderr)
    except OSError as problem:
        print(f"evaluate: {folder / 'truth.tum'}: {problem.strerror}, left out", file=sys.stderr)


def main() -> int:
    options = arguments()
    from polhode_ground.common.whole_file import check_replaceable
    from polhode_ground.judge import report
    from polhode_ground.judge.run import judge_run, read_run, read_truth_for

    if options.json:
        check_replaceable(options.json)
    from polhode_ground.common.sequence import read_sequence

    sequence = read_sequence(options.sequence)
    runs = [read_run(folder) for folder in (options.run, *options.vs)]
    from polhode_ground.judge.truth import Matching

    truth = read_truth_for(
        runs[0], sequence.timestamp_ns, options.truth or sequence.truth_path, Matching(options.truth_gap_s, options.clock_offset)
    )
    reports = [judge_run(run, sequence, truth) for run in runs]
    print(report.text_report(reports))
    for run in runs:
        write_truth(run.folder, truth)
    if options.json:
        write_json(options.json, reports)
    if options.plots:
        write_plots(options.plots, runs, truth)
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "evaluate")
