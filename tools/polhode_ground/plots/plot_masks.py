"""Draws over frames of a replay made with --masks what it took for the target: the target's outline (blue), where no
features may be made (darkened), points that the mask followed and landmarks by class (green: target, red: background,
yellow: unassigned). With truth and mesh, prints the overlap (intersection over union) of the sharpened outlines.

Examples:
  tools/plot_masks.py DIR SEQ
  tools/plot_masks.py DIR SEQ --frames 0,10,20 --out masks
"""

import argparse
import pathlib

from polhode_ground.common.venv import enter_venv, run_main


def numbers(text: str) -> list[int]:
    return [int(one) for one in text.split(",")]


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", metavar="DIR", type=pathlib.Path, help="output folder of a replay with --masks")
    parser.add_argument("sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder")
    parser.add_argument("--frames", metavar="N,N,...", type=numbers, help="frames to draw (default: nine, evenly)")
    parser.add_argument("--out", metavar="OUT", type=pathlib.Path, help="folder for the pictures (default: DIR/plots)")
    return parser.parse_args()


def main() -> int:
    options = arguments()
    import numpy as np

    from polhode_ground.common.sequence import read_sequence
    from polhode_ground.judge.landmarks import on_background, outline_overlaps
    from polhode_ground.plots import overlay, style

    sequence = read_sequence(options.sequence)
    masks = overlay.read_masks(options.run / "masks.pgms")  # before anything is made: DIR may not be there
    frames = options.frames or sorted({int(one) for one in np.linspace(0, len(sequence.filenames) - 1, 9)})
    out = options.out or options.run / "plots"
    style.prepare(out)
    for path in overlay.draw(options.run, masks, sequence, frames, out):
        print(path)
    if sequence.model_path.exists() and sequence.truth_path.exists():
        overlaps = outline_overlaps(masks, sequence)
        if overlaps:
            print(f"outlines of {len(overlaps)} keyframes: overlap mean {np.mean(overlaps):.3f}, median {np.median(overlaps):.3f}")
        outside, landmarks = on_background(options.run, sequence)
        print(f"landmarks on the background: {outside} of {landmarks}")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "plot_masks")
