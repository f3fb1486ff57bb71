"""What motion_model.json says of the body's mass, against the scene: inertia ratios, principal axes, centre of mass.

Only what the run calls observed or weak is judged; a quantity that it calls unobserved has no value to be wrong.
"""

import pathlib
from typing import Any

import numpy as np

from polhode_ground.common.sequence import read_json
from polhode_ground.judge.align import axis_angle_deg
from polhode_ground.judge.aligned import Aligned

RATIOS = ("middle_over_least", "largest_over_least")
# Moments nearer than this to each other leave their two axes free in their plane.
APART_MIN = 0.01


def _known(entry: dict[str, Any]) -> bool:
    return entry.get("value") is not None and entry["observability"] != "unobserved"


def _inertia(scene: dict[str, Any]) -> tuple[np.ndarray, np.ndarray] | None:
    """(moments [3] in rising order, their axes as columns [3,3] in the truth's T); None where the scene tells none."""
    stated = scene.get("scene", {}).get("motion", {}).get("inertia_kg_m2")
    if stated is None:
        return None
    inertia = np.asarray(stated, dtype=float)
    moments, axes = np.linalg.eigh(np.diag(inertia) if inertia.ndim == 1 else inertia)
    return moments, axes


def judge_ratio(entry: dict[str, Any], true: float) -> dict[str, Any]:
    result = {"observability": entry["observability"], "true": true, "error_percent": None, "sigmas_off": None}
    if _known(entry):
        error = entry["value"] - true
        result |= {"error_percent": 100 * error / true, "sigmas_off": abs(error) / entry["sigma"] if entry["sigma"] else None}
    return result


def judge_axes(
    axes: list[dict[str, Any]], in_order: bool, inertia: tuple[np.ndarray, np.ndarray], aligned: Aligned
) -> list[dict[str, Any]]:
    """Angles from the true principal axes; none where two moments are alike.

    @param in_order  the run knows the order of its moments, least first; else an axis may be any of the three
    """
    moments, axes_T = inertia
    alone = [bool(np.min(np.abs(np.delete(moments, k) / moments[k] - 1)) > APART_MIN) for k in range(3)]
    result = []
    for k, axis in enumerate(axes):
        judged = {"observability": axis["observability"], "error_deg": None, "sigma_deg": None}
        true = [i for i in ([k] if in_order else range(3)) if alone[i]]
        if true and axis["axis_T"] is not None and axis["observability"] != "unobserved":
            found = aligned.R_ET.inv().apply(axis["axis_T"])
            judged |= {
                "error_deg": min(axis_angle_deg(found, axes_T[:, i]) for i in true),
                "sigma_deg": None if axis["sigma_rad"] is None else float(np.degrees(axis["sigma_rad"])),
            }
        result.append(judged)
    return result


def judge_centre_of_mass(entries: list[dict[str, Any]], aligned: Aligned) -> dict[str, Any]:
    """Along each axis that the run names: its distance from where the trajectories' alignment has it [m]."""
    scale, true_E = float(aligned.similarity.scale), aligned.similarity.offset_E
    axes = []
    for entry in entries:
        judged = {"observability": entry["observability"], "error_m": None, "sigma_m": None}
        if _known(entry):
            judged |= {
                "error_m": scale * float(entry["value"] - true_E @ np.asarray(entry["axis_T"])),
                "sigma_m": scale * entry["sigma"] if entry["sigma"] is not None else None,
            }
        axes.append(judged)
    errors = [axis["error_m"] for axis in axes if axis["error_m"] is not None]
    return {
        "axes": axes,
        "axes_known": len(errors),
        "error_m": float(np.linalg.norm(errors)) if errors else None,
        "worst_axis_m": float(np.max(np.abs(errors))) if errors else None,
    }


def judge_dynamics(model_path: pathlib.Path, scene: dict[str, Any], aligned: Aligned | None) -> dict[str, Any] | None:
    """None without a fit of the dynamics."""
    model = read_json(model_path)
    if aligned is None or not model.get("inertia_ratios"):
        return None
    inertia = _inertia(scene)
    result: dict[str, Any] = {
        "inertia_ratios": None,
        "principal_axes": None,
        "centre_of_mass": judge_centre_of_mass((model.get("translation") or {}).get("centre_of_mass") or [], aligned),
    }
    if inertia is None:
        return result
    moments = inertia[0]
    result["inertia_ratios"] = {
        name: judge_ratio(model["inertia_ratios"][name], float(moments[k + 1] / moments[0])) for k, name in enumerate(RATIOS)
    }
    in_order = any(_known(model["inertia_ratios"][name]) for name in RATIOS)
    result["principal_axes"] = judge_axes(model["principal_axes_T"], in_order, inertia, aligned)
    errors = [axis["error_deg"] for axis in result["principal_axes"] if axis["error_deg"] is not None]
    result["principal_axes_worst_deg"] = max(errors) if errors else None
    return result
