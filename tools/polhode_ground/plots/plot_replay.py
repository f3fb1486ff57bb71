"""Draws what a replay found, as PNG files.

rates.png, velocity.png   against the truth (if known) with one-sigma bands
attitude_error.png        attitude and position errors over time, with the published sigmas (needs the truth)
counts.png                features, matches, inliers, landmarks, keyframes, mode and step time
cloud.png                 the cloud in three views, alone and with the camera's path
contact_sheet.png         frames with tracks and reprojected landmarks drawn in

Examples:
  tools/plot_replay.py DIR
  tools/plot_replay.py DIR --sequence SEQ --truth truth.csv --out plots
"""

import argparse
import pathlib
import sys

from polhode_ground.common.venv import enter_venv, run_main


def arguments() -> argparse.Namespace:
    from polhode_ground.judge.truth_options import add_truth_options

    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", metavar="DIR", type=pathlib.Path, help="output folder of a replay")
    parser.add_argument(
        "--sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder (default: the one that DIR/summary.json names)"
    )
    add_truth_options(parser, "truth (default: SEQ/truth.csv if it is there)")
    parser.add_argument("--out", metavar="OUT", type=pathlib.Path, help="folder for the pictures (default: DIR/plots)")
    return parser.parse_args()


def find_sequence(run, folder: pathlib.Path | None):
    """The sequence of a run; None, with a remark, where it is not known or has moved."""
    from polhode_ground.common.sequence import read_sequence

    if folder is not None:
        return read_sequence(folder)
    named = run.summary.get("sequence")
    if isinstance(named, dict):
        named = named.get("path")
    if not isinstance(named, str) or not named:
        print("plot_replay: summary.json names no sequence, so no contact sheet: give --sequence", file=sys.stderr)
        return None
    if not pathlib.Path(named).is_dir():
        print(f"plot_replay: {named}: not there any more, so no contact sheet: give --sequence", file=sys.stderr)
        return None
    return read_sequence(pathlib.Path(named))


def main() -> int:
    options = arguments()
    from polhode_ground.judge.run import read_run, read_truth_for
    from polhode_ground.judge.truth import Matching
    from polhode_ground.plots import cloud, counts, errors, motion, sheet, style

    run = read_run(options.run)
    sequence = find_sequence(run, options.sequence)
    truth_path = options.truth or (sequence.truth_path if sequence and sequence.truth_path.exists() else None)
    frames_ns = sequence.timestamp_ns if sequence else next(iter(run.motions.values())).timestamp_ns
    truth = read_truth_for(run, frames_ns, truth_path, Matching(options.truth_gap_s, options.clock_offset)) if truth_path else None
    out = options.out or options.run / "plots"
    style.prepare(out)
    paths = motion.draw(run, truth, out) + errors.draw(run, truth, out) + counts.draw(run, out)
    paths += cloud.draw(run, truth, out)
    if sequence is not None:
        paths += sheet.draw(run, sequence, out)
    for path in paths:
        print(path)
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "plot_replay")
