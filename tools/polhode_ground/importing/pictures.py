"""Single picture files: pixels as a viewer would show them, EXIF's time, EXIF's focal length."""

import datetime
import pathlib
import struct
import zlib

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing import netpbm
from polhode_ground.importing.decoding import register_heif
from polhode_ground.importing.formats import RAW_SUFFIXES, READ_BY_REPLAY, kind_of_file
from polhode_ground.importing.lens import Lens
from polhode_ground.importing.source import NS, PICTURES, VIDEOS, Account

# EXIF's numbers of the fields that are read.
ORIENTATION, EXIF_FOLDER, MAKE, MODEL = 0x0112, 0x8769, 0x010F, 0x0110
TIME_ORIGINAL, SUBSECONDS, OFFSET = 0x9003, 0x9291, 0x9011
FOCAL_MM, FOCAL_35MM = 0x920A, 0xA405
WIDTH_TAKEN, HEIGHT_TAKEN = 0xA002, 0xA003
PLANE_X, PLANE_UNIT, DIGITAL_ZOOM = 0xA20E, 0xA210, 0xA404
MM_PER_UNIT = {2: 25.4, 3: 10.0, 4: 1.0}
ASPECT_SAME = 0.005  # densities are rounded
SHAPE_SAME = 0.01  # a focal length of EXIF is no better than this; sizes are rounded
# What Pillow raises of damaged files of one format or another.
PICTURE_ERRORS = (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError, struct.error, zlib.error)
THUMBNAIL, THUMBNAIL_PX = ".thm", 320
ADVICE = "give --intrinsics FILE, 'fu,fv,cu,cv' or auto"
DIAGONAL_35MM = 43.27  # of a frame of 36 mm x 24 mm, which "35 mm equivalent" refers to (CIPA DCG-001)


def open_picture(path: pathlib.Path):
    from PIL import Image

    try:
        if kind_of_file(path) == "heic":
            register_heif()
        return Image.open(path)
    except Image.DecompressionBombError as problem:
        raise BadInput(f"{path}: {problem}") from None
    except PICTURE_ERRORS:
        raise BadInput(f"{path}: not a picture that can be read") from None


def size_of(path: pathlib.Path) -> tuple[int, int]:
    """Width and height as shown, after EXIF's orientation."""
    with open_picture(path) as picture:
        width, height = picture.size
        return (height, width) if turned(picture) >= 5 else (width, height)


def turned(picture) -> int:
    """EXIF's orientation: 1 as stored, 5 to 8 with width and height exchanged. A PNG is read to its end for it: BadInput of a torn one."""
    try:
        return int(picture.getexif().get(ORIENTATION, 1) or 1)
    except PICTURE_ERRORS as problem:
        raise BadInput(f"{getattr(picture, 'filename', 'picture')}: not all of it can be read ({problem})") from None


def may_be_copied(path: pathlib.Path) -> bool:
    """The replay reads the file as it is, and sees what a viewer shows."""
    if kind_of_file(path) not in READ_BY_REPLAY or kind_of_file(path) == "pgm" and len(netpbm.pages_of(path)) > 1:
        return False
    with open_picture(path) as picture:
        return (picture.mode in ("L", "RGB") or picture.mode.startswith("I")) and turned(picture) == 1


def pages_in_copy(path: pathlib.Path) -> int:
    """Of a file that may be copied: an animated PNG has several, of which the replay reads one."""
    if kind_of_file(path) != "png":
        return 1
    with open_picture(path) as picture:
        return getattr(picture, "n_frames", 1)


def pixel_aspect(picture) -> float:
    """Width by height of what a pixel shows, as JPEG's or PNG's density tells it; 1 where it does not."""
    across, down = picture.info.get("jfif_density") or picture.info.get("aspect") or picture.info.get("dpi") or (1, 1)
    if not (across and down and across > 0 and down > 0):
        return 1.0
    aspect = float(down) / float(across)
    if abs(aspect - 1) < ASPECT_SAME:
        return 1.0
    return 1 / aspect if turned(picture) >= 5 else aspect


def in_folder(folder: pathlib.Path, account: Account | None = None) -> list[pathlib.Path]:
    """Pictures of a folder by their content or their suffix, numbers in names in their own order: 9 before 10. Links to nothing are lost pictures."""
    entries = [path for path in folder.iterdir() if not path.name.startswith(".")]
    files = [path for path in entries if path.is_file() or is_broken(path)]
    pictures = [path for path in files if path.suffix.lower() in PICTURES or kind_of_file(path)]
    thumbnails = _thumbnails(files, pictures)
    pictures = [path for path in pictures if path not in thumbnails]
    developed = {path.stem for path in pictures if not _is_raw(path)}
    twice = [path for path in pictures if _is_raw(path) and path.stem in developed]
    if account is not None:
        _tell_others(entries, account)
        account.assumed += [f"{len(twice)} raw files are left out: pictures of the same names are there"] if twice else []
        account.assumed += [f"{len(thumbnails)} pictures are left out: thumbnails of videos"] if thumbnails else []
        others = sorted(path.name for path in set(files) - set(pictures) - thumbnails)
        account.assumed += (
            [f"{len(others)} files are no pictures: {', '.join(others[:3])}{', ...' if others[3:] else ''}"] if others else []
        )
    return sorted(set(pictures) - set(twice), key=natural_order)


def _thumbnails(files: list[pathlib.Path], pictures: list[pathlib.Path]) -> set[pathlib.Path]:
    """What cameras write beside videos. Phones write whole pictures so, too."""
    videos = {path.stem.casefold() for path in files if path.suffix.lower() in VIDEOS}
    return {path for path in pictures if videos and path.suffix.lower() == THUMBNAIL or path.stem.casefold() in videos and _is_small(path)}


def _is_small(path: pathlib.Path) -> bool:
    try:
        with open_picture(path) as picture:
            return max(picture.size) <= THUMBNAIL_PX
    except BadInput:
        return False


def is_broken(path: pathlib.Path) -> bool:
    """A link to what is not there."""
    return path.is_symlink() and not path.exists()


def _tell_others(entries: list[pathlib.Path], account: Account) -> None:
    """Pictures in folders below are not asked for."""
    folders = sorted(path.name for path in entries if path.is_dir() and any(file.suffix.lower() in PICTURES for file in path.iterdir()))
    if folders:
        account.assumed.append(
            f"{len(folders)} folders with pictures below this one are left out: {', '.join(folders[:3])}{', ...' if folders[3:] else ''}"
        )


def _is_raw(path: pathlib.Path) -> bool:
    return path.suffix.lower() in RAW_SUFFIXES or kind_of_file(path) == "raw"


def natural_order(path: pathlib.Path) -> list:
    """Numbers by their value; img.png before img (1).png."""
    import re

    stem, suffix = (path.stem, path.suffix) if re.search("[^\\W\\d]", path.suffix) else (path.name, "")
    parts = [(1, int(part), "") if part.isdecimal() else (0, 0, part) for part in re.split(r"(\d+)", stem) if part]
    return [*parts, (-1, 0, suffix)]


def exif_time_ns(path: pathlib.Path) -> int | None:
    """When it was taken, in UTC where the zone is told, else as if it were; None where it is not told or not readable."""
    try:
        with open_picture(path) as picture:
            fields = picture.getexif().get_ifd(EXIF_FOLDER)
        zone = str(fields[OFFSET]).strip() if fields.get(OFFSET) else "+00:00"
        when = datetime.datetime.strptime(f"{str(fields[TIME_ORIGINAL]).strip()} {zone}", "%Y:%m:%d %H:%M:%S %z")
        fraction = str(fields.get(SUBSECONDS, "")).strip() or "0"
        return int(when.timestamp()) * NS + int(fraction[:9].ljust(9, "0"))
    except (BadInput, *PICTURE_ERRORS):
        return None


def exif_lens(path: pathlib.Path) -> tuple[Lens, str] | None:
    """A lens from the focal length in EXIF, and how it was found; None where EXIF has none. No better than some per cent.

    @errors BadInput where EXIF was written for a picture of another shape, or does not tell what a digital zoom did
    """
    try:
        with open_picture(path) as picture:
            fields, camera, stored = picture.getexif().get_ifd(EXIF_FOLDER), picture.getexif(), picture.size
            name = " ".join(str(camera.get(tag, "")).strip("\0 ") for tag in (MAKE, MODEL)).strip() or "camera unknown"
        width, height = size_of(path)
        zoom = float(fields.get(DIGITAL_ZOOM) or 0) or 1.0  # 0: none was used
        found = _focal(fields, width, height, is_zoomed=zoom != 1)
        taken = int(fields.get(WIDTH_TAKEN) or 0), int(fields.get(HEIGHT_TAKEN) or 0)
    except (BadInput, *PICTURE_ERRORS, ZeroDivisionError):
        return None
    if found is None:
        return None
    focal_px, how, of_plane = found
    by = _resized_by(stored, taken, path) if min(taken) > 0 and taken != stored else 1.0
    if zoom != 1:
        _check_zoom(zoom, by, focal_px, of_plane, path)
        focal_px, how = focal_px * zoom, f"{how}, digital zoom {zoom:g}"
    if by != 1:
        focal_px *= by if of_plane else 1.0  # an angle holds at any size
        how += f"; EXIF is of a picture of {taken[0]}x{taken[1]}, which was resized by {by:.4g}" if abs(by - 1) > SHAPE_SAME else ""
    return Lens(width, height, (focal_px, focal_px, (width - 1) / 2, (height - 1) / 2)), f"EXIF of {path.name} ({name}: {how})"


def _check_zoom(zoom: float, by: float, focal_px: float, of_plane: bool, path: pathlib.Path) -> None:
    """@errors BadInput where the zoomed picture may be cropped and not enlarged, or the focal length hold the zoom already"""
    said = f"EXIF of {path.name} tells a digital zoom of {zoom:g}"
    if not 1 < zoom < np.inf:
        raise BadInput(f"{said}, allowed is at least 1: {ADVICE}")
    if abs(by * zoom - 1) <= SHAPE_SAME:
        raise BadInput(f"{said}, and its picture is smaller by as much: it was cropped or resized, and which is not told; {ADVICE}")
    if not of_plane:
        raise BadInput(
            f"{said}, and some cameras count it in the 35 mm equivalent and others do not: the focal length is {focal_px:.0f} px or "
            f"{zoom * focal_px:.0f} px; {ADVICE}"
        )


def _focal(fields, width: int, height: int, is_zoomed: bool) -> tuple[float, str, bool] | None:
    """(focal length [px], how it was found, whether by pixels of the focal plane). @errors those of fields that are no numbers"""
    has_plane = float(fields.get(FOCAL_MM) or 0) > 0 and float(fields.get(PLANE_X) or 0) > 0
    if float(fields.get(FOCAL_35MM) or 0) > 0 and not (is_zoomed and has_plane):
        equivalent = float(fields[FOCAL_35MM])
        return equivalent / DIAGONAL_35MM * float(np.hypot(width, height)), f"{equivalent:g} mm equivalent", False
    if has_plane:
        per_mm = float(fields[PLANE_X]) / MM_PER_UNIT[int(fields.get(PLANE_UNIT, 2))]
        return float(fields[FOCAL_MM]) * per_mm, f"{float(fields[FOCAL_MM]):g} mm, {per_mm:.4g} pixels per mm", True
    return None


def _resized_by(stored: tuple[int, int], taken: tuple[int, int], path: pathlib.Path) -> float:
    """The picture's size by the one that EXIF tells; the picture may have been turned meanwhile. @errors BadInput where the shapes differ"""
    for width, height in (taken, taken[::-1]):
        across, down = stored[0] / width, stored[1] / height
        if abs(across / down - 1) <= SHAPE_SAME:
            return across
    raise BadInput(
        f"EXIF of {path.name} is of a picture of {taken[0]}x{taken[1]}, but this one has {stored[0]}x{stored[1]}, another shape: "
        f"it was cropped, and its focal length in pixels is not known; {ADVICE}"
    )
