"""What is said of the pictures and is not so: focal length, shape of the pixels, principal point, time stamps."""

from dataclasses import replace

import numpy as np

from polhode_ground.common.fault_log import LogEntry
from polhode_ground.transforms.footage import Footage


def claimed(footage: Footage, kind: str, detail: str, intrinsics_px: np.ndarray) -> Footage:
    """The same pictures with another statement of the camera."""
    return footage.changed(
        footage.shots,
        [LogEntry(0, footage.shots[0].timestamp_ns, kind, detail)],
        camera=replace(footage.camera, intrinsics_px=intrinsics_px),
    )


def focal_length(footage: Footage, options: dict, seed: int) -> Footage:
    """sensor.yaml states `factor` times the focal length that the pictures were made with."""
    return claimed(
        footage,
        "focal_length",
        f"stated {options['factor']} times too long",
        footage.camera.intrinsics_px * [options["factor"], options["factor"], 1, 1],
    )


def aspect(footage: Footage, options: dict, seed: int) -> Footage:
    """sensor.yaml states fv / fu `factor` times as large as it is; fu is right."""
    return claimed(
        footage,
        "aspect",
        f"fv / fu stated {options['factor']} times too large",
        footage.camera.intrinsics_px * [1, options["factor"], 1, 1],
    )


def principal_point(footage: Footage, options: dict, seed: int) -> Footage:
    """sensor.yaml states the principal point elsewhere."""
    return claimed(
        footage,
        "principal_point",
        f"stated {options['du_px']}, {options['dv_px']} px away",
        footage.camera.intrinsics_px + [0, 0, options["du_px"], options["dv_px"]],
    )


def stamps(footage: Footage, options: dict, seed: int) -> Footage:
    """Time stamps run at another pace and jitter. Poses go with their pictures; rates and velocities stay those of true time."""
    first, rng = footage.shots[0].timestamp_ns, np.random.default_rng([seed, 1])
    jitter_ns = 1e9 * footage.period_s * options["jitter_part"]
    since_ns = [options["pace"] * (shot.timestamp_ns - first) + rng.uniform(-0.5, 0.5) * jitter_ns for shot in footage.shots]
    wrong = [first, *(first + int(round(since)) for since in since_ns[1:])]
    for i in range(1, len(wrong)):
        wrong[i] = max(wrong[i], wrong[i - 1] + 1)
    shots = [replace(shot, timestamp_ns=stamp) for shot, stamp in zip(footage.shots, wrong)]
    return footage.changed(shots, [LogEntry(0, wrong[0], "stamps", f"pace {options['pace']}, jitter {options['jitter_part']} of a period")])
