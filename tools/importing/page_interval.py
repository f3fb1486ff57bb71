"""The time from one page of a TIFF to the next, as microscopes' programs write it: ImageJ's text, OME's XML."""

import re

IMAGE_DESCRIPTION = 270
FIRST = "ImageJ="
INTERVAL, FRAMES, UNIT = (re.compile(rf"^{name}=(.+?)\s*$", re.MULTILINE) for name in ("finterval", "frames", "tunit"))
OME = re.compile(r"<Pixels\b[^>]*>")
ATTRIBUTE = r'\b{}="([^"]*)"'
SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0}


def interval_s(tags: dict, pages: int) -> tuple[float, str]:
    """(seconds, who says so), where the pages are those of a film; (0, "") where nobody does.

    @param tags  of the first page
    """
    text = tags.get(IMAGE_DESCRIPTION) or ""
    text = text.decode(errors="replace") if isinstance(text, bytes) else str(text)
    if text.startswith(FIRST):
        return _seconds(INTERVAL.search(text), FRAMES.search(text), UNIT.search(text), pages), "ImageJ's finterval"
    pixels = OME.search(text)
    found = [re.search(ATTRIBUTE.format(name), pixels.group()) if pixels else None for name in ("TimeIncrement", "SizeT", "TimeIncrementUnit")]
    return _seconds(*found, pages), "OME's TimeIncrement"


def _seconds(interval, frames, unit, pages: int) -> float:
    """0 of a stack whose pages are heights or colours, too."""
    try:
        value = float(interval.group(1)) * SECONDS[unit.group(1).strip().lower() if unit else "s"]
        return value if value > 0 and (frames is None or int(frames.group(1)) == pages) else 0.0
    except (AttributeError, KeyError, ValueError):
        return 0.0
