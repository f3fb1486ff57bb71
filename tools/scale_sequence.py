#!/usr/bin/env python3
"""A sequence at another size, for measurements of cost: pictures are resampled and set in the middle of black.

    tools/scale_sequence.py SEQUENCE OUT --width 1920 --height 1080

What is seen stays what it was, so truth and accuracy keep their meaning; detail that the camera did not see does not come.
"""

import argparse
import pathlib
import shutil

import yaml
from PIL import Image


def scaled_intrinsics(intrinsics: list[float], factor: float, left: int, top: int) -> list[float]:
    """Pixel centres lie at integers: the picture's edge is at -0.5."""
    fu, fv, cu, cv = intrinsics
    return [fu * factor, fv * factor, (cu + 0.5) * factor - 0.5 + left, (cv + 0.5) * factor - 0.5 + top]


def scale(sequence: pathlib.Path, out: pathlib.Path, width: int, height: int) -> int:
    """@return the number of pictures."""
    source, target = sequence / "mav0/cam0", out / "mav0/cam0"
    (target / "data").mkdir(parents=True, exist_ok=True)
    sensor = yaml.safe_load((source / "sensor.yaml").read_text())
    factor = min(width / sensor["resolution"][0], height / sensor["resolution"][1])
    size = [round(factor * n) for n in sensor["resolution"]]
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    pictures = sorted(p for p in (source / "data").iterdir() if p.is_file())
    for picture in pictures:
        canvas = Image.new("L", (width, height))
        canvas.paste(Image.open(picture).convert("L").resize(size, Image.Resampling.BICUBIC), (left, top))
        canvas.save(target / "data" / picture.name)
    sensor["resolution"] = [width, height]
    sensor["intrinsics"] = scaled_intrinsics(sensor["intrinsics"], factor, left, top)
    (target / "sensor.yaml").write_text(yaml.safe_dump(sensor, default_flow_style=None))
    shutil.copy(source / "data.csv", target / "data.csv")
    for extra in ("truth.csv", "scene.json", "model.ply"):
        if (sequence / extra).exists():
            shutil.copy(sequence / extra, out / extra)
    return len(pictures)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("sequence", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--width", type=int, required=True)
    parser.add_argument("--height", type=int, required=True)
    arguments = parser.parse_args()
    count = scale(arguments.sequence, arguments.out, arguments.width, arguments.height)
    print(f"{count} pictures of {arguments.width} x {arguments.height} in {arguments.out}")


if __name__ == "__main__":
    main()
