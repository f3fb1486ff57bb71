"""A sequence at another size, for measurements of cost: pictures are resampled and set in the middle of black.

    tools/scale_sequence.py SEQUENCE OUT --width 1920 --height 1080

What is seen stays what it was, so truth and accuracy keep their meaning; detail that the camera did not see does not come.
"""

import argparse
import json
import pathlib
import shutil

from polhode_ground.common.ranges import whole
from polhode_ground.common.venv import enter_venv, run_main

SIDE_PX_MAX = 8192  # the largest that the program takes


def scaled_intrinsics(intrinsics: list[float], factor: float, left: int, top: int) -> list[float]:
    """Pixel centres lie at integers: the picture's edge is at -0.5."""
    fu, fv, cu, cv = intrinsics
    return [fu * factor, fv * factor, (cu + 0.5) * factor - 0.5 + left, (cv + 0.5) * factor - 0.5 + top]


def scale_known_lengths(scene: pathlib.Path, factor: float, left: int, top: int) -> None:
    if not scene.exists():
        return
    content = json.loads(scene.read_text())
    for length in content.get("known_lengths", []):
        length["points_px"] = [[(u + 0.5) * factor - 0.5 + left, (v + 0.5) * factor - 0.5 + top] for u, v in length["points_px"]]
    scene.write_text(json.dumps(content, indent=2) + "\n")


def scale(sequence: pathlib.Path, out: pathlib.Path, width: int, height: int) -> int:
    """@return the number of pictures."""
    import yaml
    from PIL import Image

    from polhode_ground.common.levels import depth_of, eight_bits, read_levels

    source, target = sequence / "mav0/cam0", out / "mav0/cam0"
    sensor = yaml.safe_load((source / "sensor.yaml").read_text())
    (target / "data").mkdir(parents=True)
    factor = min(width / sensor["resolution"][0], height / sensor["resolution"][1])
    size = [round(factor * n) for n in sensor["resolution"]]
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    pictures = sorted(p for p in (source / "data").iterdir() if p.is_file())
    depth_bits = depth_of(pictures)
    for picture in pictures:
        canvas = Image.new("L", (width, height))
        canvas.paste(Image.fromarray(eight_bits(read_levels(picture)[0], depth_bits)).resize(size, Image.Resampling.BICUBIC), (left, top))
        canvas.save(target / "data" / picture.name)
    sensor["resolution"] = [width, height]
    sensor["intrinsics"] = scaled_intrinsics(sensor["intrinsics"], factor, left, top)
    (target / "sensor.yaml").write_text(yaml.safe_dump(sensor, default_flow_style=None))
    shutil.copy(source / "data.csv", target / "data.csv")
    for extra in ("truth.csv", "scene.json", "model.ply", "servicer_attitude.csv"):
        if (sequence / extra).exists():
            shutil.copy(sequence / extra, out / extra)
    scale_known_lengths(out / "scene.json", factor, left, top)
    return len(pictures)


def main() -> int:
    from polhode_ground.common.errors import BadInput

    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", metavar="SEQUENCE", type=pathlib.Path)
    parser.add_argument("out", metavar="OUT", type=pathlib.Path)
    parser.add_argument("--width", metavar="PX", type=whole(1, SIDE_PX_MAX), required=True)
    parser.add_argument("--height", metavar="PX", type=whole(1, SIDE_PX_MAX), required=True)
    arguments = parser.parse_args()
    if not (arguments.sequence / "mav0/cam0/data").is_dir():
        raise BadInput(f"{arguments.sequence}: no sequence: it has no folder mav0/cam0/data")
    if arguments.out.exists():
        raise BadInput(f"{arguments.out}: is there already")
    try:
        count = scale(arguments.sequence, arguments.out, arguments.width, arguments.height)
    except OSError as problem:
        raise BadInput(str(problem)) from None
    print(f"{count} pictures of {arguments.width} x {arguments.height} in {arguments.out}")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "scale_sequence")
