"""Sets the estimator beside COLMAP over several sequences: a row each, ours as the median over seeds of the random draws.

Replays and COLMAP's results are kept in the cache; COLMAP's are reused for the same frames, replays are made anew. CPU is
that of one frame with the work at the end, and a busy machine lengthens it: run both at the same load to compare.

Examples:
  hil/peer_table.py SEQ OTHER_SEQ --seeds 3
"""

import argparse
import pathlib
import statistics
import sys
from typing import TYPE_CHECKING, Any

from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main

if TYPE_CHECKING:
    from polhode_ground.common.sequence import Sequence
    from polhode_ground.judge.run import Run

HEADER = [
    "",
    "causal [deg]",
    "smoothed [deg]",
    "COLMAP [deg]",
    "its frames",
    "smoothed on them [deg]",
    "COLMAP follows",
    "CPU a frame [ms]",
    "COLMAP's [ms]",
    "memory [MB]",
    "COLMAP's [MB]",
]


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", metavar="SEQ", type=pathlib.Path, nargs="+", help="sequence folders with truth.csv")
    parser.add_argument("--seeds", type=int, default=3, help="replays of each (default 3)")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="as of polhode replay")
    parser.add_argument("--program", type=pathlib.Path, default=REPOSITORY / "build/release/bin/polhode")
    return parser.parse_args()


def replays(sequence: "Sequence", options: argparse.Namespace) -> list["Run"]:
    """Runs with the seeds 1 .. options.seeds."""
    from polhode_ground.common.replay import cache_folder, replay
    from polhode_ground.judge.run import read_run

    runs = []
    for seed in range(1, options.seeds + 1):
        out = cache_folder("replays", f"{sequence.name}_seed{seed}")
        print(f"{sequence.name}: replay {seed} of {options.seeds}", file=sys.stderr)
        replay(sequence.folder, out, [*options.set, f"seed={seed}"], program=options.program)
        runs.append(read_run(out))
    return runs


def row_of(folder: pathlib.Path, options: argparse.Namespace) -> list[str]:
    """Cells of one sequence; '-' for what is not there, such as the attitude of a target that was never acquired."""
    from polhode_ground.common.replay import cache_folder
    from polhode_ground.common.sequence import read_sequence
    from polhode_ground.judge import colmap, report
    from polhode_ground.judge.run import judge_run, read_run, read_truth

    sequence = read_sequence(folder)
    truth = read_truth(sequence)
    runs = replays(sequence, options)
    peer = read_run(colmap.colmap_output(sequence, cache_folder("colmap", sequence.name).absolute()))
    ours, theirs = [judge_run(run, sequence, truth) for run in runs], judge_run(peer, sequence, truth)
    shared = [colmap.attitude_on_shared_frames(run, peer, truth) for run in runs]

    def median(reports: list[dict[str, Any]], path: str, layout: str) -> str:
        found = [value for value in (report.lookup(one, path) for one in reports) if value is not None]
        return report.text_of(statistics.median(found) if found else None, layout)

    coverage = theirs["motion"]["smoothed"]["coverage"]
    return [
        sequence.name,
        median(ours, "motion.causal.attitude.rmse_deg", "{:.2f}"),
        median(ours, "motion.smoothed.attitude.rmse_deg", "{:.2f}"),
        median([theirs], "motion.smoothed.attitude.rmse_deg", "{:.2f}"),
        f"{coverage['frames_with_pose']} of {coverage['frames_in']}",
        median(shared, "smoothed.rmse_deg", "{:.2f}"),
        report.text_of(report.lookup(theirs, "motion.smoothed.twin.verdict"), "{}"),
        median(ours, "cost.cpu_total_per_frame_ms", "{:.0f}"),
        median([theirs], "cost.cpu_total_per_frame_ms", "{:.0f}"),
        median(ours, "cost.peak_resident_mb", "{:.0f}"),
        median([theirs], "cost.peak_resident_mb", "{:.0f}"),
    ]


def main() -> int:
    options = arguments()
    from polhode_ground.common.errors import BadInput
    from polhode_ground.judge.report import table

    if options.seeds < 1:
        raise BadInput(f"--seeds: at least 1, not {options.seeds}")
    print(table(HEADER, [row_of(folder, options) for folder in options.sequences]))
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "peer_table")
