"""What the levels of a sequence's pictures mean, by the rules of `polhode replay` (platform/camera/replay)."""

import pathlib
import struct

import numpy as np

from polhode_ground.common.errors import BadInput

FULL_BITS = 16
DEPTHS_BITS = (8, 10, 12, 14)  # of cameras whose levels stand unshifted in 16-bit pictures
LOOKED_AT = 5  # pictures of a sequence, evenly over it: the first ones may be dark
PNG_MAGIC, JPEG_MAGIC, PGM_MAGIC = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"P5"
# ITU-R BT.601 in 1/65536.
WEIGHTS_RGB = (19595, 38470, 7471)


def read_octets(path: pathlib.Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None


def png_bits(octets: bytes) -> int:
    """Of a level as it is stored: 1 to 16; 0: no PNG."""
    return octets[24] if octets.startswith(PNG_MAGIC) and len(octets) > 25 else 0


def significant_bits(octets: bytes) -> int:
    """Of a 16-bit picture as the file says, by sBIT or maxval; 0: it does not say."""
    if octets.startswith(PGM_MAGIC):
        header = octets[2:200].split(b"\n")
        numbers = b" ".join(line.split(b"#")[0] for line in header).split()[:3]
        return FULL_BITS if len(numbers) == 3 and numbers[2].isdigit() and 255 < int(numbers[2]) < 65535 else 0
    at = len(PNG_MAGIC)
    while octets.startswith(PNG_MAGIC) and at + 12 < len(octets):
        length, kind = struct.unpack(">I4s", octets[at : at + 8])
        if kind == b"IDAT":
            return 0
        if kind == b"sBIT" and length:
            return max(octets[at + 8 : at + 8 + (1 if length < 3 else 3)])
        at += length + 12
    return 0


def luminance(pixels: np.ndarray, order: str = "RGB") -> np.ndarray:
    """Gray [H,W] of [H,W], [H,W,1], gray with alpha, colours or colours with alpha; the number type stays. Alpha is dropped."""
    if pixels.ndim == 2 or pixels.shape[2] < 3:
        return pixels if pixels.ndim == 2 else np.ascontiguousarray(pixels[:, :, 0])
    colours = [pixels[:, :, order.index(name)] for name in "RGB"]
    if pixels.dtype.kind == "f":
        parts = [weight / 65536 * colour for weight, colour in zip(WEIGHTS_RGB, colours)]
        return (parts[0] + parts[1] + parts[2]).astype(pixels.dtype)
    whole = [weight * colour.astype(np.int64) for weight, colour in zip(WEIGHTS_RGB, colours)]
    return ((whole[0] + whole[1] + whole[2] + 32768) >> 16).astype(pixels.dtype)


def read_levels(path: pathlib.Path) -> tuple[np.ndarray, int]:
    """(gray [H,W] uint8 or uint16 as the replay decodes it, the bits that the file says or 0) of a PNG, JPEG or PGM."""
    import io

    from PIL import Image

    octets = read_octets(path)
    bits = png_bits(octets)
    try:
        if bits == FULL_BITS:
            import cv2

            pixels = cv2.imdecode(np.frombuffer(octets, np.uint8), cv2.IMREAD_UNCHANGED)
            if pixels is None:
                raise BadInput(f"{path}: not a PNG that can be read")
            return luminance(pixels, "BGR"), significant_bits(octets)
        with Image.open(io.BytesIO(octets)) as picture:
            if picture.mode.startswith("I"):
                return np.asarray(picture).astype(np.uint16), significant_bits(octets)
            return np.asarray(picture.convert("L")), 8
    except (OSError, ValueError, SyntaxError) as problem:
        raise BadInput(f"{path}: {' '.join(str(problem).split()) or 'cannot be read'}") from None


def depth_for(level: int) -> int:
    """The smallest depth of a camera that has this level."""
    return next((bits for bits in DEPTHS_BITS if level < 1 << bits), FULL_BITS)


def depth_of(paths: list[pathlib.Path]) -> int:
    """Bits of the largest level in a sequence's 16-bit pictures; 16 for others. By a few pictures, as the replay does it."""
    largest, said = 0, 0
    for path in paths[:: max(1, len(paths) // LOOKED_AT)]:
        try:
            levels, bits = read_levels(path)
        except BadInput:
            continue
        if levels.dtype == np.uint8:
            continue  # says nothing of those beside it
        if bits == FULL_BITS:
            return FULL_BITS
        largest, said = max(largest, int(levels.max(initial=0))), max(said, bits)
    found = depth_for(largest) if largest else FULL_BITS
    return found if said == 0 or found == FULL_BITS else max(found, min(said, FULL_BITS))


def eight_bits(levels: np.ndarray, depth_bits: int) -> np.ndarray:
    """uint8 of levels that use so many bits; what is brighter is cut."""
    if levels.dtype == np.uint8:
        return levels
    return np.asarray(np.minimum(levels >> (depth_bits - 8), 255), np.uint8)


def viewable(octets: bytes) -> str | None:
    """ "png" or "jpeg" where every viewer shows the file as the replay sees it: 8 bits a level; None for others."""
    if octets.startswith(JPEG_MAGIC):
        return "jpeg"
    return "png" if 0 < png_bits(octets) <= 8 else None
