"""FITS, as telescopes and scientific cameras write it: one picture, or a cube of them."""

import io
import pathlib
import warnings

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import luminance

TURNED = "rows of FITS are taken from the bottom up, as the standard shows them"
TOP_DOWN = "TOP-DOWN"  # of ROWORDER, which cameras' programs write who store them as they came


def _library():
    try:
        from astropy.io import fits
    except ImportError:
        raise BadInput("FITS needs the package astropy: run tools/setup.sh, or convert the pictures") from None
    warnings.filterwarnings("ignore", module="astropy")  # what can't be read is told in our words
    return fits


def _opened(source):
    """The first part with a picture in it. @param source  a path, or a file in memory"""
    parts = _library().open(source, memmap=False)  # parts are read when they are asked for
    part = next((part for part in parts if getattr(part, "is_image", False) and len(getattr(part, "shape", ()) or ()) >= 2), None)
    if part is None:
        raise BadInput("a FITS file without a picture")
    return part


def _upright(part, pixels: np.ndarray) -> tuple[np.ndarray, str]:
    pixels = pixels.astype(pixels.dtype.newbyteorder("="))
    said = f"; a mosaic ({part.header['BAYERPAT']}) is left as it is" if "BAYERPAT" in part.header else ""
    if str(part.header.get("ROWORDER", "")).strip().upper() == TOP_DOWN:
        return pixels, said.lstrip("; ")
    return np.ascontiguousarray(pixels[::-1]), TURNED + said


def picture_of(octets: bytes) -> tuple[np.ndarray, str, int]:
    """(gray levels as they are, a remark, the number of pictures in it)."""
    part = _opened(io.BytesIO(octets))
    data = part.data
    if data.ndim == 3 and len(data) == 3:
        data, count = luminance(np.moveaxis(data, 0, 2).astype(data.dtype.newbyteorder("="))), 1
    else:
        count = int(np.prod(data.shape[:-2]))
        data = data.reshape(count, *data.shape[-2:])[0]
    return *_upright(part, data), count


def pages_of(path: pathlib.Path) -> int:
    """Pictures of a cube; 3 planes are colours."""
    count = int(np.prod(_opened(str(path)).shape[:-2]))
    return 1 if count == 3 else count


def pages(path: pathlib.Path):
    """Gray levels of each picture of a cube, with a remark."""
    part = _opened(str(path))
    for index in np.ndindex(part.shape[:-2]):
        yield _upright(part, part.section[(*index, slice(None), slice(None))])


def time_ns(path: pathlib.Path) -> int | None:
    """DATE-OBS: when the exposure began, in UTC; None where the file does not tell it to the second."""
    try:
        header = _opened(str(path)).header
        when = str(header.get("DATE-OBS", "")).strip()
        when = when if "T" in when else f"{when}T{str(header.get('TIME-OBS') or header.get('UT') or '').strip()}"
        return int(np.datetime64(when.removesuffix("Z"), "ns").astype(np.int64)) if len(when) > 12 else None
    except (BadInput, OSError, ValueError, TypeError):
        return None
