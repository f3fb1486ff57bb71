"""Slow motion and time lapse: the rate at which a camera took the frames, where the video tells that it plays at another."""

import mmap
import pathlib
import re

from polhode_ground.importing.source import Account

ANDROID = "com.android.capture.fps"
APPLE_MODE = "com.apple.photos.captureMode"
# Sony's XML beside the video, as "119.88p".
SONY = re.compile(rb'captureFps="([\d.]+)[pi]?"')
SONY_PLAYED = re.compile(rb'formatFps="([\d.]+)[pi]?"')
SAME = 0.02  # rates that are rounded


def slowed_by(path: pathlib.Path, container, stream, account: Account) -> float:
    """By how much longer a second of the world takes in the video than it took; 1 where the video tells nothing else."""
    play = float(stream.average_rate or 0)
    capture, played, who = _told(path, container, stream)
    if capture <= 0 or (played or play) <= 0:
        return 1.0
    slowed = capture / (played or play)
    if abs(slowed - 1) < SAME:
        return 1.0
    account.assumed.append(
        f"{who} tells that the camera took {capture:g} frames a second, played at {played or play:.4g}: "
        f"times are {f'{slowed:.4g} times shorter' if slowed > 1 else f'{1 / slowed:.4g} times longer'} than the video's"
    )
    return slowed


def _told(path: pathlib.Path, container, stream) -> tuple[float, float, str]:
    """(rate of the camera, rate that it is played at or 0, who says so)."""
    tags = {**container.metadata, **stream.metadata}
    if ANDROID in tags:
        return _number(tags[ANDROID]), 0.0, f"the tag {ANDROID}"
    if container.format.name.startswith("mov") and path.is_file():
        with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as octets:
            capture, played = SONY.search(octets), SONY_PLAYED.search(octets)
            if capture and played:
                return _number(capture.group(1)), _number(played.group(1)), "captureFps of the camera's XML"
    return 0.0, 0.0, ""


def _number(text) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0


def tell_mode(container, account: Account) -> None:
    """Phones that tell the mode, but no rate."""
    mode = str(container.metadata.get(APPLE_MODE, ""))
    if "lapse" in mode.lower():
        account.assumed.append(
            f"the video is a time lapse ({APPLE_MODE}), and does not tell how fast time runs: rates and velocity are those of the film"
        )
