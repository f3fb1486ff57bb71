"""Single picture files: pixels as a viewer would show them, EXIF's time, EXIF's focal length."""

import datetime
import pathlib

import numpy as np
from importing.lens import Lens
from importing.source import NS, PICTURES

from judge.errors import BadInput

# EXIF's numbers of the fields that are read.
ORIENTATION, EXIF_FOLDER, MAKE, MODEL = 0x0112, 0x8769, 0x010F, 0x0110
TIME_ORIGINAL, SUBSECONDS, OFFSET = 0x9003, 0x9291, 0x9011
FOCAL_MM, FOCAL_35MM = 0x920A, 0xA405
PLANE_X, PLANE_UNIT = 0xA20E, 0xA210
MM_PER_UNIT = {2: 25.4, 3: 10.0, 4: 1.0}
DIAGONAL_35MM = 43.27  # of a frame of 36 mm x 24 mm, which "35 mm equivalent" refers to (CIPA DCG-001)


def open_picture(path: pathlib.Path):
    from PIL import Image
    try:
        return Image.open(path)
    except OSError:
        raise BadInput(f"{path}: not a picture that can be read") from None


def size_of(path: pathlib.Path) -> tuple[int, int]:
    """Width and height as shown, after EXIF's orientation."""
    with open_picture(path) as picture:
        width, height = picture.size
        return (height, width) if turned(picture) >= 5 else (width, height)


def turned(picture) -> int:
    """EXIF's orientation: 1 as stored, 5 to 8 with width and height exchanged."""
    return int(picture.getexif().get(ORIENTATION, 1) or 1)


def read_pixels(path: pathlib.Path) -> np.ndarray:
    """Gray [H,W], uint8 or uint16, turned as EXIF says."""
    from PIL import ImageOps
    with open_picture(path) as picture:
        try:
            picture = ImageOps.exif_transpose(picture)
            if picture.mode.startswith("I") or picture.mode == "F":
                return np.clip(np.asarray(picture), 0, 65535).astype(np.uint16)
            return np.asarray(picture.convert("L"))
        except OSError as problem:
            raise BadInput(f"{path}: {problem}") from None


def in_folder(folder: pathlib.Path) -> list[pathlib.Path]:
    """Pictures of a folder, numbers in names in their own order: 9 before 10."""
    return sorted((path for path in folder.iterdir() if path.suffix.lower() in PICTURES and not path.name.startswith(".")), key=natural_order)


def natural_order(path: pathlib.Path) -> list:
    import re
    return [(1, int(part), "") if part.isdigit() else (0, 0, part) for part in re.split(r"(\d+)", path.name) if part]


def exif_time_ns(path: pathlib.Path) -> int | None:
    """When it was taken, in UTC where the zone is told, else as if it were; None where it is not told or not readable."""
    try:
        with open_picture(path) as picture:
            fields = picture.getexif().get_ifd(EXIF_FOLDER)
        zone = str(fields[OFFSET]).strip() if fields.get(OFFSET) else "+00:00"
        when = datetime.datetime.strptime(f"{str(fields[TIME_ORIGINAL]).strip()} {zone}", "%Y:%m:%d %H:%M:%S %z")
        fraction = str(fields.get(SUBSECONDS, "")).strip() or "0"
        return int(when.timestamp()) * NS + int(fraction[:9].ljust(9, "0"))
    except (BadInput, KeyError, ValueError):
        return None


def exif_lens(path: pathlib.Path) -> tuple[Lens, str] | None:
    """A lens from the focal length in EXIF, and how it was found; None where EXIF has none. No better than some per cent."""
    try:
        with open_picture(path) as picture:
            fields, camera = picture.getexif().get_ifd(EXIF_FOLDER), picture.getexif()
            name = " ".join(str(camera.get(tag, "")).strip("\0 ") for tag in (MAKE, MODEL)).strip() or "camera unknown"
        width, height = size_of(path)
    except BadInput:
        return None
    focal_px, how = None, ""
    try:
        if float(fields.get(FOCAL_35MM) or 0) > 0:
            equivalent = float(fields[FOCAL_35MM])
            focal_px, how = equivalent / DIAGONAL_35MM * float(np.hypot(width, height)), f"{equivalent:g} mm equivalent"
        elif float(fields.get(FOCAL_MM) or 0) > 0 and float(fields.get(PLANE_X) or 0) > 0:
            per_mm = float(fields[PLANE_X]) / MM_PER_UNIT[int(fields.get(PLANE_UNIT, 2))]
            focal_px, how = float(fields[FOCAL_MM]) * per_mm, f"{float(fields[FOCAL_MM]):g} mm, {per_mm:.4g} pixels per mm"
    except (ValueError, KeyError, ZeroDivisionError):
        return None
    if focal_px is None:
        return None
    return Lens(width, height, (focal_px, focal_px, (width - 1) / 2, (height - 1) / 2)), f"EXIF of {path.name} ({name}: {how})"
