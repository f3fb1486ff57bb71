"""Makes one page of a run that needs no other file: DIR/report.html.

It says in words what was found, warnings first, and shows modes, rates, velocity, errors where the truth is known, the
motion as a law with its prediction, the cloud in three dimensions, frames with the outline drawn in, and what it cost.

Examples:
  tools/report.py DIR
  tools/report.py DIR --replay SEQ         replays first
  tools/report.py DIR --video run.mp4
  tools/report.py DIR --rrd run.rrd        for the Rerun viewer (tools/setup.sh extras)
  tools/report.py DIR --sequence SEQ --truth truth.csv --out page.html
"""

import argparse
import pathlib
import sys

from polhode_ground.common.venv import enter_venv, run_main


def arguments() -> argparse.Namespace:
    from polhode_ground.judge.truth_options import add_truth_options

    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 made, also of a run that never acquired; 2 unusable input (one line says which).",
    )
    parser.add_argument("run", metavar="DIR", type=pathlib.Path, help="output folder of a replay")
    parser.add_argument(
        "--sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder (default: the one that DIR/summary.json names)"
    )
    add_truth_options(parser, "truth (default: SEQ/truth.csv if it is there)")
    parser.add_argument("--out", metavar="FILE", type=pathlib.Path, help="the page (default: DIR/report.html)")
    parser.add_argument(
        "--replay",
        metavar="SEQ",
        type=pathlib.Path,
        help="replay this sequence into DIR first, as `polhode replay` does with config/default.toml",
    )
    parser.add_argument(
        "--set", metavar="key=value", action="append", default=[], help="a setting for --replay, as in --set scale.known_length_m=0.6"
    )
    parser.add_argument(
        "--video", metavar="FILE.mp4", type=pathlib.Path, help="also write the sequence with surface, outline, axes and tracks drawn in"
    )
    parser.add_argument(
        "--rrd",
        metavar="FILE.rrd",
        type=pathlib.Path,
        help="also write a Rerun recording: camera, pictures, cloud, surface, axes, rates, events",
    )
    return parser.parse_args()


def main() -> int:
    options = arguments()
    from polhode_ground.common.errors import BadInput
    from polhode_ground.common.whole_file import check_replaceable, write_whole
    from polhode_ground.judge.truth import Matching
    from polhode_ground.reporting.gather import gather
    from polhode_ground.reporting.page import page

    if options.set and options.replay is None:
        raise BadInput("--set: is for --replay")
    out = options.out or options.run / "report.html"
    for file in filter(None, (out, options.video, options.rrd)):
        check_replaceable(file)  # before the work
    if options.replay is not None:
        from polhode_ground.common.replay import replay

        print(f"replaying {options.replay}", file=sys.stderr)
        replay(options.replay, options.run, options.set)
    material = gather(options.run, options.sequence, options.truth, Matching(options.truth_gap_s, options.clock_offset))
    text = page(material)
    try:
        write_whole(out, text)
    except OSError as problem:
        raise BadInput(f"{out}: {problem.strerror}") from None
    print(out)
    if options.video is not None:
        from polhode_ground.reporting.video import write_video

        print(f"{options.video}: {write_video(material, options.video)} frames")
    if options.rrd is not None:
        from polhode_ground.reporting.rerun_file import write_rrd

        print(f"{options.rrd}: {write_rrd(material, options.rrd)} poses")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "report")
