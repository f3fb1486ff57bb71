"""Runs COLMAP on a sequence, with the same intrinsics, and judges it beside a replay.

COLMAP (pycolmap, in a virtual environment of its own: .venv-colmap, made on first use) sees all frames at once and runs
on the CPU with default features, fixed OPENCV intrinsics and exhaustive matching up to 150 frames, else sequential. Its
trajectory is written as motion_smoothed.csv, so hil/evaluate.py reads the output folder like any run. In narrow fields
of view COLMAP may return the depth-reversed twin with every frame registered: the table names it.

Examples:
  hil/compare_colmap.py SEQ
  hil/compare_colmap.py SEQ --run DIR
"""

import argparse
import pathlib
from typing import TYPE_CHECKING

from polhode_ground.common.venv import enter_venv, run_main

if TYPE_CHECKING:
    from polhode_ground.common.tables import Motion
    from polhode_ground.judge.run import Run


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder")
    parser.add_argument(
        "--run",
        metavar="RUN",
        type=pathlib.Path,
        nargs="+",
        default=[],
        help="output folders of replays of the same sequence, set beside COLMAP",
    )
    parser.add_argument(
        "--out", metavar="DIR", type=pathlib.Path, help="output folder (default: colmap/NAME in the cache); a finished one is reused"
    )
    parser.add_argument("--again", action="store_true", help="run COLMAP even if its result is there")
    parser.add_argument("--json", metavar="FILE", type=pathlib.Path, help="write the reports as JSON")
    return parser.parse_args()


def print_shared_frames(run: "Run", peer: "Run", truth: "Motion") -> None:
    """One line for each motion file: its attitude error over COLMAP's frames alone, so that nobody gains by leaving some out."""
    from polhode_ground.judge.colmap import attitude_on_shared_frames

    for kind, found in attitude_on_shared_frames(run, peer, truth).items():
        name = "COLMAP" if run is peer else f"{run.name} {kind}"
        print(f"{name}: attitude RMSE {found['rmse_deg']:.3f} deg over {found['frames']} of COLMAP's frames")


def print_other_models(out: pathlib.Path, truth: "Motion") -> None:
    """One line for each smaller model: how it lies to the truth and its twin."""
    from polhode_ground.judge.aligned import align_last
    from polhode_ground.judge.run import read_run
    from polhode_ground.judge.twin import judge_twin

    for folder in sorted(out.glob("model_*"), key=lambda path: int(path.name.removeprefix("model_"))):
        aligned = align_last(read_run(folder).motions["smoothed"], truth)
        if aligned is None:
            continue
        found = judge_twin(aligned.R_CE, aligned.R_CT, truth.p_CT[aligned.rows_T])
        print(
            f"COLMAP's {folder.name}: {len(aligned.rows_E)} frames, {found['verdict']} "
            f"({found['rmse_to_truth_deg']:.2f} deg from the truth, {found['rmse_to_twin_deg']:.2f} deg from its twin)"
        )


def main() -> int:
    options = arguments()
    from polhode_ground.common.whole_file import check_replaceable
    from polhode_ground.judge.evaluate import write_json

    if options.json:
        check_replaceable(options.json)
    from polhode_ground.common.replay import cache_folder
    from polhode_ground.common.sequence import read_sequence
    from polhode_ground.judge import colmap, report
    from polhode_ground.judge.run import judge_run, read_run, read_truth

    sequence = read_sequence(options.sequence)
    truth = read_truth(sequence) if sequence.truth_path.exists() else None
    runs = [read_run(folder) for folder in options.run]
    out = (options.out or cache_folder("colmap", sequence.name)).absolute()
    colmap.colmap_output(sequence, out, options.again)
    peer = read_run(out)
    print(
        f"{peer.summary['program']}: {peer.summary['models']} model(s), {peer.summary.get('points')} points, "
        f"mean reprojection error {report.text_of(peer.summary.get('mean_reprojection_error_px'), '{:.2f}')} px, "
        f"in {out}"
    )
    if truth is None:
        print(f"{sequence.truth_path}: not there, nothing to judge by")
        return 0
    reports = [judge_run(run, sequence, truth) for run in (peer, *runs)]
    reports[0]["run"] = "COLMAP"
    print(report.text_report(reports))
    for run in (peer, *runs):
        print_shared_frames(run, peer, truth)
    print_other_models(out, truth)
    if options.json:
        write_json(options.json, reports)
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "compare_colmap")
