"""Makes a surface that follows the body's cloud, and puts it in the place of the convex hull: DIR/surface.ply.

The program's own surface.ply is the convex hull of cloud.ply, which closes every hollow. This one is a Poisson surface
through the points and their normals (COLMAP's, by pycolmap in .venv-colmap, which the first call makes). It is closed.
Where no measured point is near, it is a guess: `added` is 1 and the colour orange there. A later replay into DIR writes
the hull again. tools/report.py and hil/evaluate.py read either.

Examples:
  tools/surface.py DIR
  tools/surface.py DIR && tools/report.py DIR --video run.mp4
"""

import argparse
import pathlib

from polhode_ground.common.venv import enter_venv, run_main


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 made; 2 unusable input (one line says which).",
    )
    parser.add_argument("run", metavar="DIR", type=pathlib.Path, help="output folder of a replay")
    options = parser.parse_args()
    from polhode_ground.common.errors import BadInput
    from polhode_ground.reporting.surface import make_surface

    try:
        faces, measured = make_surface(options.run)
    except OSError as problem:
        raise BadInput(f"{problem.filename or options.run}: {problem.strerror}") from None
    print(f"{options.run / 'surface.ply'}: {faces} faces, {100 * measured:.0f} % of the area measured")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "surface")
