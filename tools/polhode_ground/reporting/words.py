"""The result in words, and what a reader must know before believing it."""

import numpy as np

from polhode_ground.judge.report import lookup, notes
from polhode_ground.reporting.gather import Material

COVERAGE_EXPECTED = 0.95
CONSISTENT_EXPECTED = 0.95  # of the frames should lie within the 95 % bound of their sigmas


def result(material: Material) -> str:
    said = material.run.summary.get("result")
    if said:
        return said
    motion = next(iter(material.run.motions.values()))
    return f"Poses on {int(motion.pose_valid.sum())} of {len(motion.timestamp_ns)} frames."


def warnings(material: Material) -> list[str]:
    """The most serious first; empty where there is nothing to say."""
    found = (
        [*_of_lengths(material), *_of_the_model(material)] if acquired(material) else []
    )  # nothing else needs to be said of what was not found
    return [
        *_of_the_start(material),
        *_of_acquisition(material),
        *_of_truth(material),
        *found,
        *_of_input(material),
        *_of_the_machine(material),
        *material.remarks,
    ]


def acquired(material: Material) -> bool:
    return bool(next(iter(material.run.motions.values())).pose_valid.any())


def _of_the_start(material: Material) -> list[str]:
    """What the program found doubtful of the sequence, without the folder before the file's name."""
    folder = str(material.run.summary.get("sequence", ""))
    return [str(said).removeprefix(folder).lstrip("/") for said in material.run.summary.get("warnings") or []]


def _of_acquisition(material: Material) -> list[str]:
    summary, motion = material.run.summary, next(iter(material.run.motions.values()))
    if not acquired(material):
        return [
            "The target was never acquired: there is no attitude, rate or shape. The counts below tell whether enough of it was seen; "
            "a target must fill some 60 pixels, show texture and turn."
        ]
    told, first = [], int(np.argmax(motion.pose_valid))
    after = float(motion.pose_valid[first:].mean())
    if after < COVERAGE_EXPECTED:
        told.append(f"After the first pose {100 * (1 - after):.0f} % of the frames have none.")
    if summary.get("mode_at_end") in ("LOST", "COASTING"):
        told.append(f"At the end the target is not seen (mode {summary['mode_at_end']}).")
    frames = 0 if motion.target_frame is None else len(np.unique(motion.target_frame[motion.pose_valid]))
    if frames > 1:
        told.append(
            f"The map was begun anew: attitudes are in {frames} different frames of the target. Only those of one frame compare; "
            "cloud and motion model are of the last."
        )
    return told


def _of_truth(material: Material) -> list[str]:
    if material.judged is None:
        return []
    told = [note for note in notes([material.judged]) if "TWIN" in note or "neither" in note or "NOT the file" in note]
    for kind, judged in material.judged["motion"].items():
        for name in ("attitude", "position", "velocity", "rate"):
            share = lookup(judged, f"consistency.{name}.within_95_percent_bound")
            if share is not None and share < CONSISTENT_EXPECTED:
                told.append(
                    f"{kind}: the {name} is within the 95 % bound of its sigma on {100 * share:.0f} % of the frames only; "
                    "its sigma promises too much."
                )
    return told


def _of_lengths(material: Material) -> list[str]:
    scale = material.shape.get("scale") or {}
    told = []
    if scale.get("contradiction"):
        told.append("The readings of the scale contradict each other: lengths are in map units.")
    elif material.shape and not scale.get("known"):
        told.append(
            "The scale is not known: lengths are in map units of unknown size. Angles, rates and periods do not depend on it. "
            "Give [scale] known_length_m to have metres."
        )
    return told


def _of_input(material: Material) -> list[str]:
    told, counters = [], material.run.summary.get("counters") or {}
    if material.imported.get("nominal_time"):
        told.append("The pictures tell no time; one a second was assumed. Rates, periods and velocity are per picture, not per second.")
    if material.imported.get("lost"):
        told.append(f"Of what was imported, {material.imported['lost']}: import.json of the sequence says why.")
    where = str(material.imported.get("intrinsics_from", ""))
    if where.startswith("EXIF"):
        told.append(f"The focal length is from {where}: it may be wrong by some per cent, and all distances with it.")
    if "sigma_focal_px" in material.sensor:
        told.append(
            "The focal length was estimated from the pictures, with a sigma of "
            f"{material.sensor['sigma_focal_px']} px. The sigmas on this page hold it as far as the pictures could test it."
        )
    bad = {
        name.removeprefix("frames_").replace("_", " "): count
        for name, count in counters.items()
        if name.startswith("frames_") and name not in ("frames_in", "frames_used") and count
    }
    if bad:
        told.append(
            f"Of {counters.get('frames_in', '?')} frames some were not used or with care: "
            f"{', '.join(f'{count} {name}' for name, count in bad.items())}."
        )
    return told


def _of_the_model(material: Material) -> list[str]:
    fit, told = material.model.get("fit") or {}, []
    if material.model and fit.get("status") not in (None, "accepted"):
        told.append(
            f"The torque-free motion was not accepted ({str(fit['status']).replace('_', ' ')}): inertia and prediction are not to be relied on."
        )
    if (lookup(material.shape, "shape.completion.points") or 0) > 0:
        told.append(
            f"{material.shape['shape']['completion']['points']} points of the cloud were not measured: "
            "completion added them, they are marked in orange."
        )
    return told


def _of_the_machine(material: Material) -> list[str]:
    summary, told = material.run.summary, []
    missed = lookup(summary, "deadline.missed")
    if missed:
        told.append(f"{missed} frames took longer than the deadline.")
    for name, text in (("steps_short_of_memory", "steps ran short of memory"), ("tables_full", "times a table was full")):
        if lookup(summary, f"counters.{name}"):
            told.append(f"{summary['counters'][name]} {text}.")
    return told
