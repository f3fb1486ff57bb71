"""Puts the page of a run together."""

import math
import pathlib

import jinja2
from plotly.offline import get_plotlyjs

from polhode_ground.common.whole_file import MARK
from polhode_ground.judge.report import lookup
from polhode_ground.reporting import corridor, figures, frames, scene, tables, words
from polhode_ground.reporting.gather import Material

TEMPLATE = "page.html.jinja"
CONFIG = {"responsive": True, "displayModeBar": False}  # drag to enlarge, touch twice to go back
NO_POSE = "There is nothing to draw: the run has no such values."


def tiles(material: Material) -> list[tuple[str, str]]:
    """The few figures that everybody asks for first."""
    motion, model = next(iter(material.run.motions.values())), material.model
    found = [("frames with a pose", f"{int(motion.pose_valid.sum())} of {len(motion.timestamp_ns)}")]
    mean = lookup(model, "model.mean_rate_rad_s")
    if mean is not None:
        found.append(("mean rate of rotation", f"{math.degrees(mean):.3g} deg/s"))
    period = lookup(model, "periods_s.rotation.value") or lookup(model, "model.rotation_period_s")
    if period is not None:
        found.append(("one rotation takes", f"{period:.4g} s"))
    dimensions = lookup(material.shape, "shape.dimensions")
    if dimensions:
        unit = {"m": "m"}.get(material.shape.get("unit"), "map units")
        found.append((f"size, {unit}", " x ".join(f"{size:.2f}" for size in dimensions)))
    if material.judged is not None:
        error = lookup(material.judged, "motion.smoothed.attitude.rmse_deg")
        if error is not None:
            found.append(("attitude error, smoothed", f"{error:.2g} deg"))
    return found


def _section(title: str, hint: str, figure, rows=(), absent: str = NO_POSE) -> dict:
    html = figure.to_html(full_html=False, include_plotlyjs=False, config=CONFIG) if figure is not None else ""
    return {"title": title, "hint": hint, "figure": html, "rows": list(rows), "absent": "" if rows else absent}


def sections(material: Material) -> list[dict]:
    return [*_motion_sections(material), *_other_sections(material)]


def _motion_sections(material: Material) -> list[dict]:
    known = material.truth is not None
    return [
        _section(
            "When what happened",
            "The mode of the estimator and its own events. ACQUIRING: it looks for the target's motion. TRACKING: poses come from what is seen. "
            "COASTING: they are predicted. LOST: there are none.",
            figures.timeline(material),
        ),
        _section(
            "How it turns",
            f"Angular velocity in the body's axes{', beside the truth in red' if known else ''}. Dots: as it was known at each frame. Line: from all frames. "
            "Bands: one sigma.",
            figures.rates(material),
        ),
        _section(
            "How it moves",
            "Velocity of the body's origin in camera axes; z is away from the camera. The origin circles the centre of mass, so a turning body shows waves.",
            figures.velocity(material),
        ),
        *(
            [
                _section(
                    "How wrong it is",
                    "Distance from the truth (line) and what the estimator itself promised (dashes). The line should mostly be below 2.8 times its dashes. "
                    "The published sigma of a position holds the scale's; the last panel shows both without it.",
                    figures.errors(material),
                )
            ]
            if known
            else []
        ),
        _section(
            "The motion as a law",
            "What a free body's motion fixes: periods, ratios of the moments of inertia, centre of mass. Below, where it will be: bars and band are one sigma.",
            figures.prediction(material),
            tables.motion_rows(material),
            "No torque-free motion was fitted, so nothing is predicted.",
        ),
    ]


def _other_sections(material: Material) -> list[dict]:
    approach = corridor.corridor(material)
    return [
        *(
            [
                _section(
                    "Where it may be approached",
                    "The corridor of one face, from corridor.csv. Green: open, as the face looks at the servicer and its normal is known well enough.",
                    approach,
                )
            ]
            if approach is not None
            else []
        ),
        _section(
            "What it looks like",
            "Drag to turn, scroll to come nearer. Touch a name below the picture to hide or show it; surface and camera's path are hidden at first.",
            scene.scene(material),
            tables.shape_rows(material),
            "No cloud was made.",
        ),
        _section(
            "What each frame gave",
            "Few features: the target is small, dark or smooth. Few inliers: it was seen, but did not fit the map.",
            figures.counts(material),
        ),
        _section(
            "What it cost", "Time and memory on the machine of this run.", figures.step_times(material), tables.machine_rows(material)
        ),
    ]


def page(material: Material) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(pathlib.Path(__file__).parent), autoescape=True, undefined=jinja2.StrictUndefined
    )
    made = sections(material)
    header, truth_rows = tables.truth_rows(material)
    sequence = material.run.summary.get("sequence") or material.run.name
    return environment.get_template(TEMPLATE).render(
        mark=MARK,
        title=pathlib.Path(str(sequence)).name,
        warnings=words.warnings(material),
        acquired=words.acquired(material),
        result=words.result(material),
        tiles=tiles(material),
        frames=frames.picked(material),
        sections=made,
        has_figures=any(one["figure"] for one in made),
        plotly=get_plotlyjs(),
        truth_header=header,
        truth_rows=truth_rows,
        counters=tables.counter_rows(material),
        folder=str(material.run.folder),
        version=material.run.summary.get("version", "unknown"),
        bus=str(lookup(material.run.summary, "bus.sha256") or ""),
    )
