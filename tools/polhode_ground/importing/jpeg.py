"""Whether all of a JPEG is there, by the rules that the replay's own decoder follows (platform/camera/jpeg_remarks.hpp)."""

import io
import re

from polhode_ground.common.errors import BadInput

END = b"\xff\xd9"
STRAY = re.compile(r"(\d+) extraneous bytes before marker 0x(\w\w)")
STRAY_MAX = 16  # octets before a marker that are passed over; more of changing values are data that was not understood


def whole(octets: bytes) -> bytes:
    """The picture with its end marker, which some cameras leave out; BadInput where data is missing or damaged."""
    ended = octets if END in octets[-STRAY_MAX:] or octets.rstrip(b"\0").endswith(END) else octets + END
    remark = _remark(ended)
    if remark == "Premature end of JPEG file" and ended is octets:  # what looked like the end marker was another's
        ended = octets + END
        remark = _remark(ended)
    if remark and not _harmless(remark, ended):
        raise BadInput(remark)
    if ended is not octets and _in_several_scans(octets):
        raise BadInput("its end is missing, and maybe whole scans")
    return ended


def _remark(octets: bytes) -> str:
    """What the library has to say of the picture; empty where nothing."""
    import simplejpeg

    try:
        simplejpeg.decode_jpeg(octets, colorspace="GRAY", strict=True)
    except ValueError as problem:
        return str(problem)
    return ""


def _harmless(remark: str, octets: bytes) -> bool:
    stray = STRAY.search(remark)
    if stray is None:
        return False
    count, marker = int(stray.group(1)), octets.rfind(END)
    filled = stray.group(2) == "d9" and len(set(octets[marker - count : marker])) == 1
    return count <= STRAY_MAX or filled


def _in_several_scans(octets: bytes) -> bool:
    from PIL import Image

    with Image.open(io.BytesIO(octets)) as picture:
        return bool(picture.info.get("progressive"))
