"""Tables of the page: rows (what, value, remark), all as texts."""

import math

from polhode_ground.judge.report import MOTION_ROWS, UNKNOWN, lookup, text_of
from polhode_ground.reporting.gather import Material

OBSERVED = {"observed": "", "weak": "weakly observed", "unobserved": "not observed"}


def with_sigma(value, sigma, unit: str = "") -> str:
    """As many digits as the sigma gives sense to."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    unit = f" {unit}" if unit else ""
    if sigma is None or not math.isfinite(sigma) or sigma <= 0:
        return f"{value:.4g}{unit}"
    digits = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{digits}f} ± {sigma:.{digits}f}{unit}"


def motion_rows(material: Material) -> list[tuple[str, str, str]]:
    """Periods, inertia, centre of mass, velocity: what motion_model.json says."""
    model, rows = material.model, []
    unit = material.model.get("length_unit", "map units")
    mean = lookup(model, "model.mean_rate_rad_s")
    if mean is not None:
        rows.append(("mean rate of rotation", f"{math.degrees(mean):.4g} deg/s", "over all frames"))
    for name, title in (
        ("rotation", "one rotation takes"),
        ("spin", "spin about the long or short axis, period"),
        ("precession", "precession, period"),
    ):
        rows += _entry(lookup(model, f"periods_s.{name}"), title, "s")
    for name, title in (
        ("middle_over_least", "moments of inertia, middle over least"),
        ("largest_over_least", "moments of inertia, largest over least"),
    ):
        rows += _entry(lookup(model, f"inertia_ratios.{name}"), title, "")
    speed = lookup(model, "translation.speed")
    if speed is not None:
        sigma = lookup(model, "translation.sigma_v_C")
        rows.append(("speed of the centre of mass", with_sigma(speed, max(sigma) if sigma else None, f"{unit}/s"), ""))
    for number, entry in enumerate(lookup(model, "translation.centre_of_mass") or [], 1):
        rows += _entry(entry, f"centre of mass along axis {number}", unit)
    return rows


def _entry(entry: dict | None, title: str, unit: str) -> list[tuple[str, str, str]]:
    if not entry:
        return []
    value = entry.get("value") if entry.get("observability") != "unobserved" else None
    return [(title, with_sigma(value, entry.get("sigma"), unit), OBSERVED.get(entry.get("observability"), ""))]


def shape_rows(material: Material) -> list[tuple[str, str, str]]:
    shape, unit = material.shape.get("shape") or {}, material.shape.get("unit", "map units")
    unit = unit.replace("_", " ")
    rows = []
    sigmas = shape.get("sigma_dimensions") or [None] * 3
    rest = shape.get("dimensions_rest_on") or [""] * 3
    for axis, value, sigma, on in zip("xyz", shape.get("dimensions") or [], sigmas, rest):
        rows.append((f"size along {axis}", with_sigma(value, sigma, unit), f"by {on}" if on else ""))
    for number, plane in enumerate(shape.get("planes") or [], 1):
        size = " x ".join(f"{length:.3g}" for length in plane["extents"])
        rows.append((f"plane {number}", f"{size} {unit}", f"{plane['inliers']} points"))
    cylinder = shape.get("cylinder")
    if cylinder:
        rows.append(("cylinder, radius", with_sigma(cylinder.get("radius"), cylinder.get("sigma_radius"), unit), ""))
    if shape.get("cloud_points") is not None:
        rows.append(("points in the cloud", str(shape["cloud_points"]), f"of {shape.get('landmarks', '?')} landmarks"))
    scale = material.shape.get("scale") or {}
    if scale.get("known"):
        percent = 100 * scale["sigma"] / scale["metres_per_map_unit"]
        rows.append(("scale", f"known to {percent:.2g} %", f"by {scale.get('source', '')}"))
    return rows


def truth_rows(material: Material) -> tuple[list[str], list[list[str]]]:
    """(header, rows) of the judge's figures; no rows without truth."""
    if material.judged is None:
        return [], []
    motions = material.judged["motion"]
    rows = [[title, *(text_of(lookup(judged, path), layout) for judged in motions.values())] for title, path, layout in MOTION_ROWS]
    return ["", *motions], [row for row in rows if any(cell != UNKNOWN for cell in row[1:])]


def machine_rows(material: Material) -> list[tuple[str, str, str]]:
    summary, rows = material.run.summary, []
    for title, path, factor, unit in (
        ("time of a step, median", "timings.step.p50_us", 1e-3, "ms"),
        ("time of a step, 99 of 100 below", "timings.step.p99_us", 1e-3, "ms"),
        ("time of a step, longest", "timings.step.max_us", 1e-3, "ms"),
        ("processor time of a frame, mean", "cost.cpu_per_frame_s", 1e3, "ms"),
        ("memory of the process, peak", "memory.peak_resident_octets", 1e-6, "MB"),
        ("memory planned", "memory.planned_octets", 1e-6, "MB"),
        ("memory allowed", "memory.budget_octets", 1e-6, "MB"),
        ("telemetry", "bus.octets", 1e-3, "kB"),
    ):
        value = lookup(summary, path)
        if value is not None:
            rows.append((title, _quantity(factor * value, unit), ""))
    return rows


def _quantity(value: float, unit: str) -> str:
    """Three digits, and whole where there are more before the point."""
    return f"{value:.3g} {unit}" if abs(value) < 999.5 else f"{value:,.0f} {unit}".replace(",", " ")


def counter_rows(material: Material) -> list[tuple[str, str]]:
    counters = material.run.summary.get("counters") or {}
    return [(name.replace("_", " "), f"{value:,}".replace(",", " ")) for name, value in counters.items()]
