"""Frames that are not what their time stamps say: repeated, stale, missing, foreign, torn, in another order.

Truth stays that of the time stamp, so a repeated picture's own pose is not its truth. Only `shuffled` moves truth with
the pictures: each picture is right, their order is none that a body could have.
"""

from dataclasses import replace

import cv2
import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.fault_log import LogEntry
from polhode_ground.transforms.camera_faults import tear
from polhode_ground.transforms.footage import Footage, Shot, noisy

# The first frames stay as they are, so that there is something to repeat.
SPARED = 2


def _chosen(footage: Footage, options: dict, seed: int, spared: int = SPARED) -> list[int]:
    """`fraction` of the frames at random, in runs of `run_frames`."""
    length, count = options.get("run_frames", 1), len(footage.shots)
    runs = round(options["fraction"] * count / length)
    places = np.arange(spared, max(spared + 1, count - length), length)
    starts = np.random.default_rng([seed, 1]).choice(places, size=min(runs, len(places)), replace=False)
    return sorted({int(start) + i for start in starts for i in range(length) if start + i < count - 1})


def _spoiled(footage: Footage, frames: list[int], kind: str, change) -> Footage:
    """change(frame, shot, shots so far) -> (shot, detail) at the given frames."""
    shots, log = [], []
    for frame, shot in enumerate(footage.shots):
        if frame in frames:
            shot, detail = change(frame, shot, shots)
            log.append(LogEntry(frame, shot.timestamp_ns, kind, detail))
        shots.append(shot)
    return footage.changed(shots, log)


def repeated(footage: Footage, options: dict, seed: int) -> Footage:
    """The picture delivered before comes again, octet for octet."""
    return _spoiled(
        footage, _chosen(footage, options, seed), "repeated", lambda frame, shot, before: (shot.showing(before[-1]), "the picture before")
    )


def near_repeated(footage: Footage, options: dict, seed: int) -> Footage:
    """The picture delivered before comes again, encoded anew: no octet need be the same."""

    def change(frame, shot, before):
        rng = [seed, 2, frame]
        return shot.showing(before[-1]).redrawn(
            lambda gray: noisy(gray, options["sigma_gray"], np.random.default_rng(rng))
        ), "the picture before, with noise"

    return _spoiled(footage, _chosen(footage, options, seed), "near_repeated", change)


def stale(footage: Footage, options: dict, seed: int) -> Footage:
    """An old buffer comes under a new time stamp."""
    age = options["age_frames"]
    if age + 1 >= len(footage.shots):
        raise BadInput(f"stale: age_frames = {age}: the sequence has {len(footage.shots)} frames only")
    return _spoiled(
        footage,
        _chosen(footage, options, seed, spared=age),
        "stale",
        lambda frame, shot, before: (shot.showing(footage.shots[frame - age]), f"the picture of {age} frames before"),
    )


def missing(footage: Footage, options: dict, seed: int) -> Footage:
    """Frames that never come."""
    gone = _chosen(footage, options, seed)
    return footage.changed(
        [shot for frame, shot in enumerate(footage.shots) if frame not in gone],
        [LogEntry(frame, footage.shots[frame].timestamp_ns, "missing", "never came") for frame in gone],
    )


def excerpt(footage: Footage, options: dict, seed: int) -> Footage:
    """Some frames in a row, as if the camera had been turned on later: another start at the same target."""
    first, frames = options["first_frame"], options["frames"]
    if first + 2 > len(footage.shots):
        raise BadInput(f"excerpt: first_frame = {first}: the sequence has {len(footage.shots)} frames only, and two are the least")
    kept = range(first, first + frames)
    return footage.changed(
        footage.shots[first : first + frames],
        [LogEntry(frame, shot.timestamp_ns, "excerpt", "left out") for frame, shot in enumerate(footage.shots) if frame not in kept],
    )


def _foreign_picture(shape, rng) -> np.ndarray:
    """Another scene altogether: discs and bars of all sizes on an uneven ground."""
    height, width = shape
    ground = cv2.resize(rng.uniform(20, 160, (6, 8)).astype(np.float32), (width, height), interpolation=cv2.INTER_CUBIC)
    picture = np.clip(ground, 0, 255).astype(np.uint8)
    for _ in range(60):
        centre = (int(rng.integers(width)), int(rng.integers(height)))
        size, gray = int(rng.integers(3, max(4, height // 6))), int(rng.integers(256))
        if rng.random() < 0.5:
            cv2.circle(picture, centre, size, gray, -1, cv2.LINE_AA)
        else:
            cv2.rectangle(picture, centre, (centre[0] + size, centre[1] + size // 2 + 1), gray, -1)
    return noisy(picture, 2.0, rng)


def foreign(footage: Footage, options: dict, seed: int) -> Footage:
    """Pictures of something else; those of one run show the same scene."""
    frames = _chosen(footage, options, seed)
    shape, first = (footage.camera.height_px, footage.camera.width_px), {}
    for frame in frames:
        first[frame] = first.get(frame - 1, frame)

    def change(frame, shot, _before):
        key = [seed, 2, first[frame]]
        return replace(shot, pixels=lambda: _foreign_picture(shape, np.random.default_rng(key)), file=None), "another scene"

    return _spoiled(footage, frames, "foreign", change)


def torn(footage: Footage, options: dict, seed: int) -> Footage:
    """The upper or lower half is still the picture before."""

    def change(frame, shot, before):
        picture, detail = tear(shot.pixels(), before[-1].pixels(), np.random.default_rng([seed, 2, frame]))
        return replace(shot, pixels=lambda: picture, file=None), detail

    return _spoiled(footage, _chosen(footage, options, seed), "torn", change)


def halves(footage: Footage, options: dict, seed: int) -> Footage:
    """The upper half of every picture is still the picture before."""

    def change(frame, shot, _before):
        row = footage.camera.height_px // 2
        picture = np.concatenate([footage.shots[frame - 1].pixels()[:row], shot.pixels()[row:]])
        return replace(shot, pixels=lambda: picture, file=None), f"rows 0 to {row - 1} of the frame before"

    return _spoiled(footage, list(range(1, len(footage.shots))), "halves", change)


def _restamped(shot: Shot, timestamp_ns: int, **fields) -> Shot:
    return replace(shot, timestamp_ns=timestamp_ns, **fields)


def shuffled(footage: Footage, options: dict, seed: int) -> Footage:
    """All pictures in random order under the old time stamps. Each has its pose; there is no velocity and no rate."""
    order = np.random.default_rng([seed, 1]).permutation(len(footage.shots))
    unknown = np.full(3, np.nan)
    shots = [_restamped(footage.shots[source], shot.timestamp_ns, v_C=unknown, w_T=unknown) for source, shot in zip(order, footage.shots)]
    return footage.changed(
        shots,
        [
            LogEntry(frame, shot.timestamp_ns, "shuffled", f"picture {source}")
            for frame, (source, shot) in enumerate(zip(order, footage.shots))
        ],
    )


def rate_jump(footage: Footage, options: dict, seed: int) -> Footage:
    """From a frame on the body turns and moves `factor` times as fast: later frames are taken every `factor`-th.

    Backwards with a negative factor. The time between frames stays; the sequence ends where the source has no more.
    """
    count, factor = len(footage.shots), options["factor"]
    at = min(max(1, round(options["at_part"] * count)), count - 1)
    later = footage.shots[at::factor] if factor > 0 else footage.shots[at - 1 :: factor][1:]
    stamps = [shot.timestamp_ns for shot in footage.shots]
    shots = footage.shots[:at] + [
        _restamped(shot, stamp, v_C=factor * shot.v_C, w_T=factor * shot.w_T) for shot, stamp in zip(later, stamps[at:])
    ]
    return footage.changed(shots, [LogEntry(at, stamps[at], "rate_jump", f"{factor} times as fast from here on")])
