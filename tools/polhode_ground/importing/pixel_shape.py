"""Pixels that are no squares: COLMAP's one focal length holds for both axes, so it is given pictures that were made square."""

import pathlib

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.sensor_text import values_of

ASPECT_SAME = 0.002  # nearer to square the stretching would change no picture by two pixels


def aspect_of(sensor: pathlib.Path) -> float:
    """Width by height of a pixel: as the source told it, or as fu and fv have it that are to be estimated again."""
    import yaml

    try:
        values = values_of(sensor.read_bytes().decode("utf-8-sig", errors="surrogateescape"))
        intrinsics = values.get("intrinsics", "auto")
        aspect = float(values.get("pixel_aspect", 1.0 if intrinsics == "auto" else float(intrinsics[1]) / float(intrinsics[0])))
    except (yaml.YAMLError, AttributeError, TypeError, ValueError, IndexError, ZeroDivisionError, OSError) as problem:
        raise BadInput(f"{sensor}: the shape of its pixels can't be read: {' '.join(str(problem).split())}") from None
    if not 0.1 < aspect < 10:
        raise BadInput(f"{sensor}: pixels {aspect:.4g} times as wide as high, allowed is 0.1 to 10")
    return aspect


def stretch_of(aspect: float) -> tuple[float, float]:
    """By how much width and height grow until pixels are square."""
    return (1.0, 1.0) if abs(aspect - 1) < ASPECT_SAME else (max(aspect, 1.0), max(1.0, 1.0 / aspect))


def stretch(images: pathlib.Path, names: list[str], by: tuple[float, float]) -> None:
    from PIL import Image

    for name in names if by != (1.0, 1.0) else []:
        with Image.open(images / name) as picture:
            size = tuple(round(side * factor) for side, factor in zip(picture.size, by))
            square = picture.convert("L").resize(size, Image.Resampling.BICUBIC)
        (images / name).unlink()  # it may be a link to the sequence's own file
        square.save(images / name, quality=95)
