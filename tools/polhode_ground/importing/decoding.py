"""Pictures of every kind in memory as gray [H,W] of the number type that they hold; nothing is scaled or cut here.

OpenCV reads what has more than 8 bits, Pillow the others, FFmpeg films' formats, LibRaw cameras' raw files, libheif HEIC, astropy FITS.
"""

import contextlib
import io
import pathlib
import re
import struct
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import FULL_BITS, luminance, png_bits, significant_bits
from polhode_ground.importing import fits, jpeg, netpbm
from polhode_ground.importing.formats import RAW_SUFFIXES, kind_of

TRANSPARENT = "transparency is left out: transparent pixels show the colour that the file has below them"
ONE_BIT = "the pictures have one bit: black and white alone"
BY_FFMPEG = {"exr": "exr", "dpx": "dpx", "pam": "pam"}
DEEP = ("tiff", "jpeg 2000", "avif", "hdr")  # may hold more than 8 bits, which Pillow cuts
FLOATS = re.compile(
    r"(gray|ya|gbra?|rgba?)p?f(16|32)(le|be)$"
)  # FFmpeg's names of formats: planes or packed colours, bits, order of octets
COLOUR_NETPBM = (b"P3", b"P6")
PAM_HEADER_MAX = 1024
ORIENTATION, DNG_VERSION = 0x0112, 50706
PHOTOMETRIC, WHITE_IS_ZERO, BITS_PER_SAMPLE = 262, 0, 258
INVERTED = "the TIFF says that 0 is white: its levels are inverted"


@dataclass
class Decoded:
    """Pixels, the bits that 16-bit levels are known to use (0: not known), and what was done to get them."""

    pixels: np.ndarray
    bits: int = 0
    remark: str = ""
    pages: int = 1  # of which the first was read


def decode(octets: bytes, name: str) -> Decoded:
    """@param name  for messages, and for raw files that begin like a TIFF. @throws BadInput where it can't be read"""
    from PIL import UnidentifiedImageError

    kind = kind_of(octets)
    if kind is None:
        raise BadInput(f"{name}: not a picture that can be read")
    try:
        octets = jpeg.whole(octets) if kind == "jpeg" else octets
        if kind == "raw" or kind == "tiff" and _is_raw(octets, name):
            return _by_libraw(octets, name)
        if kind == "fits":
            pixels, remark, pages = fits.picture_of(octets)
            return Decoded(pixels, remark=remark, pages=pages)
        if kind in BY_FFMPEG:
            found = _by_ffmpeg(octets, BY_FFMPEG[kind])
            found.bits = found.bits or FULL_BITS * (kind == "pam" and b"MAXVAL 65535" not in octets[:PAM_HEADER_MAX])  # scaled up by MAXVAL
            return found
        if kind == "numpy":
            return _numpy(octets)
        deep = kind in DEEP or png_bits(octets) == FULL_BITS or octets[:2] in COLOUR_NETPBM
        return (_by_opencv(octets, kind) if deep else None) or _by_pillow(octets, kind)
    except BadInput as problem:
        raise BadInput(f"{name}: {problem}") from None
    except UnidentifiedImageError:
        raise BadInput(
            f"{name}: a {kind} file that can't be read (damaged, or of a kind that is not known here: convert it to PNG or TIFF)"
        ) from None
    except Exception as problem:  # a damaged file: every library has errors of its own
        raise BadInput(
            f"{name}: a {kind} file that can't be read ({' '.join(str(problem).split())[:120] or type(problem).__name__})"
        ) from None


def tiff_tags(file) -> dict:
    """Of the first page: a mosaic, too. @param file  its path, or a stream. Empty where it is damaged."""
    return next(tags_of_pages(file))


def tags_of_pages(file) -> Iterator[dict]:
    """Page by page, without an end: empty from where it is damaged, and behind the last."""
    from PIL import TiffImagePlugin

    with open(file, "rb") if isinstance(file, pathlib.Path) else file as stream:
        try:
            begin = stream.read(16)
            tags = TiffImagePlugin.ImageFileDirectory_v2(begin if begin[2:3] == b"+" or begin[3:4] == b"+" else begin[:8])
            while tags.next:
                with warnings.catch_warnings(action="ignore"):
                    stream.seek(tags.next)
                    tags.load(stream)
                yield dict(tags)
        except (OSError, SyntaxError, ValueError, EOFError, struct.error):
            pass
    while True:
        yield {}


def black_is_zero(pixels: np.ndarray, tags: dict, remark: str = "") -> tuple[np.ndarray, str]:
    """(levels that grow with the light, what is to be said). OpenCV sees to 8 bits itself, and leaves others as they stand."""
    if tags.get(PHOTOMETRIC) != WHITE_IS_ZERO or pixels.dtype == np.uint8:
        return pixels, remark
    if pixels.dtype.kind != "u":
        raise BadInput(
            f"a TIFF of {pixels.dtype.name} levels that says that 0 is white: which level is black is not told; write it with PhotometricInterpretation 1"
        )
    bits = tags.get(BITS_PER_SAMPLE, 0)
    largest = 2 ** int(bits[0] if isinstance(bits, tuple) else bits or 8 * pixels.dtype.itemsize) - 1
    return (largest - np.minimum(pixels, largest)).astype(pixels.dtype), INVERTED


def _is_raw(octets: bytes, name: str) -> bool:
    return name.lower().endswith(RAW_SUFFIXES) or DNG_VERSION in tiff_tags(io.BytesIO(octets))


def _by_opencv(octets: bytes, kind: str) -> Decoded | None:
    """None where it is 8 bits of a usual kind (Pillow knows palettes and CMYK), or OpenCV does not read it."""
    import cv2

    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # a file that it can't read is told in our words
    pixels = cv2.imdecode(np.frombuffer(octets, np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.dtype == np.uint8:
        return None
    gray, bits = luminance(pixels, "BGR"), significant_bits(octets)
    remark = TRANSPARENT if pixels.ndim == 3 and pixels.shape[2] == 4 else ""
    if kind == "tiff":
        gray, remark = black_is_zero(gray, tiff_tags(io.BytesIO(octets)), remark)
    return Decoded(gray if kind == "tiff" else _turned(gray, octets), bits, remark)  # OpenCV turns a TIFF itself


def _turned(pixels: np.ndarray, octets: bytes) -> np.ndarray:
    """As EXIF's orientation says; formats that Pillow does not know have none."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(io.BytesIO(octets)) as picture:
            turn = int(picture.getexif().get(ORIENTATION, 1) or 1)
    except UnidentifiedImageError:
        return pixels
    if turn >= 5:
        pixels = pixels.T
    flips = {2: (1,), 3: (0, 1), 4: (0,), 6: (1,), 7: (0, 1), 8: (0,)}.get(turn, ())
    return np.ascontiguousarray(np.flip(pixels, flips))


def _by_pillow(octets: bytes, kind: str) -> Decoded:
    from PIL import Image, ImageOps

    if kind == "heic":
        register_heif()
    with Image.open(io.BytesIO(octets)) as picture:
        pages = 1 if kind == "jpeg" else getattr(picture, "n_frames", 1)
        alpha = picture.mode in ("LA", "PA", "RGBA", "La", "RGBa") or "transparency" in picture.info
        picture = ImageOps.exif_transpose(picture)
        if picture.mode.startswith("I") or picture.mode == "F":
            pixels = np.asarray(picture)
            # Pillow has 16-bit levels of Netpbm as 32 bits, scaled to 16 by maxval.
            if kind in ("pnm", "pgm") and pixels.dtype.kind == "i":
                return Decoded(pixels.astype(np.uint16), FULL_BITS if kind == "pnm" else significant_bits(octets))
            return Decoded(pixels, pages=pages)
        gray = np.asarray((picture.convert("RGB") if picture.mode in ("LAB", "HSV") else picture).convert("L"))
        remark = TRANSPARENT if alpha else ONE_BIT if picture.mode == "1" else ""
        return Decoded(gray, 8, remark, pages)


def register_heif() -> None:
    try:
        import pillow_heif
    except ImportError:
        raise BadInput("HEIC needs the package pillow-heif: run tools/setup.sh, or convert the pictures") from None
    pillow_heif.register_heif_opener()


def _by_libraw(octets: bytes, name: str) -> Decoded:
    try:
        import rawpy
    except ImportError:
        raise BadInput("a camera's raw file needs the package rawpy: run tools/setup.sh, or convert the pictures") from None
    with rawpy.imread(io.BytesIO(octets)) as raw:
        # Brightened alike in all pictures, not each by itself.
        colours = raw.postprocess(output_bps=16, no_auto_bright=True, use_camera_wb=True)
    return Decoded(luminance(colours), FULL_BITS, "a camera's raw file was developed by LibRaw")


def _by_ffmpeg(octets: bytes, demuxer: str) -> Decoded:
    import av

    with av.open(io.BytesIO(octets), format=f"{demuxer}_pipe") as container:
        return frame_levels(next(container.decode(video=0)))


def _numpy(octets: bytes) -> Decoded:
    pixels = np.load(io.BytesIO(octets), allow_pickle=False)
    if pixels.ndim not in (2, 3) or pixels.ndim == 3 and pixels.shape[2] not in (1, 3, 4):
        raise BadInput(f"a NumPy array of {'x'.join(map(str, pixels.shape))}, needed are rows, columns and up to 4 colours")
    if pixels.dtype == bool:
        return Decoded(luminance(np.where(pixels, np.uint8(255), np.uint8(0))), 8, ONE_BIT)
    return Decoded(
        luminance(pixels), 0, "colours of NumPy arrays are taken to be red, green, blue" if pixels.ndim == 3 and pixels.shape[2] > 1 else ""
    )


def frame_levels(frame) -> Decoded:
    """Of a frame of FFmpeg. Levels of more than 8 bits fill 16, but 16-bit gray is as it was: nobody knows how much of it is used."""
    name, bits = frame.format.name, max(part.bits for part in frame.format.components)
    if FLOATS.match(name):
        return _floats(frame)
    if name.startswith("bayer"):
        colours = frame.to_ndarray(format="rgb48le" if bits > 8 else "rgb24")
        return Decoded(luminance(colours), FULL_BITS if bits > 8 else 8, f"the mosaic {name} became gray")
    if bits <= 8:
        return Decoded(frame.to_ndarray(format="gray"), 8)
    return Decoded(frame.to_ndarray(format="gray16le"), 0 if name.startswith("gray16") else FULL_BITS)


def _floats(frame) -> Decoded:
    """Levels as they are stored: FFmpeg's conversions cut them at 1, and make 0 of NaN."""
    order, bits, end = FLOATS.match(frame.format.name).groups()
    order, channels = order.upper(), 1 if frame.format.is_planar or order == "gray" else len(order)
    kind, planes = np.dtype(f"{'>' if end == 'be' else '<'}f{int(bits) // 8}"), []
    for plane in frame.planes:
        rows = np.frombuffer(plane, kind).reshape(plane.height, -1)
        planes.append(rows[:, : frame.width * channels].reshape(plane.height, frame.width, channels))
    return Decoded(luminance(np.concatenate(planes, axis=2).astype(np.float32), order))


def read_picture(path: pathlib.Path) -> Decoded:
    try:
        octets = path.read_bytes()
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None
    decoded = decode(octets, str(path))
    if kind_of(octets) == "tiff" and decoded.remark in ("", TRANSPARENT, INVERTED):
        decoded.pages = pages_of_tiff(path)
    if kind_of(octets) in ("pgm", "pnm"):
        decoded.pages = max(1, len(netpbm.places_of(octets)))
    return decoded


def pages_of_tiff(path: pathlib.Path) -> int:
    """1 of a camera's raw file: what else is in it is smaller copies."""
    import cv2

    if path.suffix.lower() in RAW_SUFFIXES:
        return 1
    with name_in_utf8(path) as name:
        return max(1, cv2.imcount(name, cv2.IMREAD_UNCHANGED))


@contextlib.contextmanager
def name_in_utf8(path: pathlib.Path) -> Iterator[str]:
    """A name of the file that OpenCV takes: it ends the process at one that is not UTF-8."""
    try:
        str(path).encode()
        yield str(path)
    except UnicodeEncodeError:
        with tempfile.TemporaryDirectory(prefix="polhode_name_") as folder:
            link = pathlib.Path(folder) / f"file{path.suffix if path.suffix.isascii() else ''}"
            link.symlink_to(path.absolute())
            yield str(link)
