"""Bad frames of a camera chain, mixed: the transform "faults".

Every fault is what such a chain produces: pixels far too dark or too bright, a buffer delivered twice, a picture whose
upper or lower part is still the one before, flipped bits (single ones all over, whole lines, or a block), a frame that
never comes. A repeated buffer holds what was delivered last, faults included.
"""

from dataclasses import replace

import numpy as np

from polhode_ground.common.fault_log import LogEntry
from polhode_ground.transforms.footage import Footage

KINDS = ("dark", "saturated", "frozen", "torn", "bits", "dropped")


def plan(frames: int, fraction: float, seed: int, kinds=KINDS) -> dict[int, str]:
    """Kind by frame: `fraction` of all frames at random, the kinds in equal shares.

    The first two frames stay good, and the last: when that never comes, nothing tells of it.
    """
    rng = np.random.default_rng([seed, 1])
    count = round(fraction * frames)
    chosen = np.sort(rng.choice(np.arange(2, frames - 1), size=min(count, max(frames - 3, 0)), replace=False))
    shares = [kinds[i % len(kinds)] for i in range(len(chosen))]
    return dict(zip(chosen.tolist(), rng.permutation(shares).tolist()))


def darken(gray, rng):
    factor = rng.uniform(0.01, 0.1)
    return (gray * factor).astype(np.uint8), f"factor {factor:.3f}"


def saturate(gray, rng):
    factor = rng.uniform(4.0, 10.0)
    return np.minimum(255, gray * factor).astype(np.uint8), f"factor {factor:.2f}"


def tear(gray, before, rng):
    """Half of the frame is the one before, from the top or from the bottom."""
    row = int(rng.uniform(0.4, 0.6) * len(gray))
    torn = gray.copy()
    if rng.random() < 0.5:
        torn[:row] = before[:row]
        return torn, f"rows 0 to {row - 1} of the frame before"
    torn[row:] = before[row:]
    return torn, f"rows from {row} of the frame before"


def flip_bits(gray, rng):
    """Single bits all over, or every bit with chance one in four in a few lines or in a block."""
    salted = gray.copy()
    style = rng.choice(["pixels", "lines", "block"])
    if style == "pixels":
        share = 10 ** rng.uniform(-2.7, -1.7)
        hit = rng.random(gray.shape) < share
        bits = (1 << rng.integers(0, 8, gray.shape)).astype(np.uint8)
        salted[hit] ^= bits[hit]
        return salted, f"one bit of {share:.4f} of the pixels"
    noise = np.packbits(rng.random((*gray.shape, 8)) < 0.25, axis=-1)[..., 0]
    if style == "lines":
        rows = rng.choice(len(gray), size=int(rng.integers(3, 20)), replace=False)
        salted[rows] ^= noise[rows]
        return salted, f"{len(rows)} lines"
    height, width = (int(rng.uniform(0.1, 0.3) * side) for side in gray.shape)
    top, left = int(rng.integers(0, gray.shape[0] - height)), int(rng.integers(0, gray.shape[1] - width))
    block = np.s_[top : top + height, left : left + width]
    salted[block] ^= noise[block]
    return salted, f"block of {width} x {height} at {left}, {top}"


def spoil(kind, gray, before, rng):
    """Pixels and detail of one fault that leaves a picture."""
    if kind == "dark":
        return darken(gray, rng)
    if kind == "saturated":
        return saturate(gray, rng)
    if kind == "torn":
        return tear(gray, before, rng)
    if kind == "bits":
        return flip_bits(gray, rng)
    return before, "the frame delivered before"


def faults(footage: Footage, options: dict, seed: int) -> Footage:
    """`fraction` of the frames spoiled, the kinds in equal shares; the log says which and how."""
    planned = plan(len(footage.shots), options["fraction"], seed)
    shots, log = [], []
    for frame, shot in enumerate(footage.shots):
        kind = planned.get(frame)
        if kind is None:
            shots.append(shot)
        elif kind == "dropped":
            log.append(LogEntry(frame, shot.timestamp_ns, kind, "never came"))
        else:
            spoiled, detail = spoil(kind, shot.pixels(), shots[-1].pixels(), np.random.default_rng([seed, 2, frame]))
            shots.append(replace(shot, pixels=lambda kept=spoiled: kept, file=None))
            log.append(LogEntry(frame, shot.timestamp_ns, kind, detail))
    return footage.changed(shots, log)
