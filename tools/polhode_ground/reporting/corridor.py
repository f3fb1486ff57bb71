"""An approach corridor on the page of a run: corridor.csv, as platform/capi/example/corridor.c writes it."""

import math
import pathlib

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import numbers, read_cells
from polhode_ground.plots import style
from polhode_ground.reporting.figures import HEIGHT_PX, colour, laid_out
from polhode_ground.reporting.gather import Material

NAME = "corridor.csv"
COLUMNS = (
    "ahead_s",
    "known",
    "p_C_x",
    "p_C_y",
    "p_C_z",
    "normal_C_x",
    "normal_C_y",
    "normal_C_z",
    "sigma_p",
    "sigma_normal_deg",
    "facing_deg",
    "half_angle_deg",
    "open",
)
SIGMAS = 3.0
AXIS_SHARE = 0.1  # of the range: the length of an axis that is drawn
CONES_MAX = 24


def read_corridor(path: pathlib.Path) -> dict[str, np.ndarray] | None:
    """Columns by name, a row a second; what was not known is NaN. None without the file."""
    if not path.exists():
        return None
    names, rows = read_cells(path)
    missing = [name for name in COLUMNS if name not in names]
    if missing or not rows:
        raise BadInput(f"{path}: {'no column ' + missing[0] if missing else 'no rows'}")
    found = {name: numbers(path, name, [row[names.index(name)] for row in rows]) for name in COLUMNS}
    for name in COLUMNS[2:-1]:
        found[name][found["known"] == 0] = math.nan
    return found


def open_spans(corridor: dict[str, np.ndarray]) -> list[tuple[float, float]]:
    """[(first, last)] seconds ahead in which the corridor is open without a break."""
    is_open = np.concatenate([[0], corridor["open"], [0]]).astype(int)
    begins, ends = np.flatnonzero(np.diff(is_open) == 1), np.flatnonzero(np.diff(is_open) == -1) - 1
    return [(float(corridor["ahead_s"][begin]), float(corridor["ahead_s"][end])) for begin, end in zip(begins, ends)]


def corridor(material: Material) -> go.Figure | None:
    """How squarely the face is seen and how wide its corridor is; beside them its centre and its normals in camera axes."""
    try:
        found = read_corridor(material.run.folder / NAME)
    except BadInput as problem:
        material.remarks.append(f"The corridor is left out: {problem}")
        return None
    if found is None:
        return None
    figure = make_subplots(
        rows=2,
        cols=2,
        column_widths=[0.55, 0.45],
        horizontal_spacing=0.08,
        vertical_spacing=0.14,
        specs=[[{}, {"type": "scene", "rowspan": 2}], [{}, None]],
        subplot_titles=["from the face's normal to the servicer [deg]", "", "half-angle of the corridor [deg]"],
    )
    _over_time(figure, found)
    _in_space(figure, found)
    figure.update_layout(height=HEIGHT_PX[2])
    return laid_out(figure, "seconds after the last frame")


def _over_time(figure: go.Figure, found: dict[str, np.ndarray]) -> None:
    ahead, facing, width = found["ahead_s"], found["facing_deg"], SIGMAS * found["sigma_normal_deg"]
    known = np.isfinite(facing)
    figure.add_trace(
        go.Scatter(
            x=np.concatenate([ahead[known], ahead[known][::-1]]),
            y=np.concatenate([(facing + width)[known], np.maximum(0, facing - width)[known][::-1]]),
            fill="toself",
            mode="lines",
            line={"width": 0},
            fillcolor=colour(style.SMOOTHED, 0.25),
            name="3 sigma",
        ),
        row=1,
        col=1,
    )
    figure.add_trace(go.Scatter(x=ahead, y=facing, mode="lines", line={"color": style.SMOOTHED}, name="face to servicer"), row=1, col=1)
    figure.add_trace(
        go.Scatter(x=ahead, y=found["half_angle_deg"], mode="lines", line={"color": style.CAUSAL}, name="half-angle, safe by 3 sigma"),
        row=2,
        col=1,
    )
    for begin, end in open_spans(found):
        for row in (1, 2):
            figure.add_vrect(x0=begin, x1=end, fillcolor=style.GOOD, opacity=0.2, line_width=0, row=row, col=1)


def _in_space(figure: go.Figure, found: dict[str, np.ndarray]) -> None:
    p = np.stack([found[f"p_C_{axis}"] for axis in "xyz"], axis=1)
    normal = np.stack([found[f"normal_C_{axis}"] for axis in "xyz"], axis=1)
    rows = np.flatnonzero(np.isfinite(p).all(axis=1))
    figure.add_trace(
        go.Scatter3d(
            x=p[rows, 0], y=p[rows, 1], z=p[rows, 2], mode="lines", line={"color": "#7a8087", "width": 3}, name="centre of the face"
        ),
        row=1,
        col=2,
    )
    drawn = rows[np.unique(np.linspace(0, len(rows) - 1, CONES_MAX).astype(int))] if len(rows) else rows
    for name, is_open, line in (("normal, open", 1, style.GOOD), ("normal, closed", 0, style.TRUTH)):
        points = [
            [*np.stack([p[i], p[i] + AXIS_SHARE * np.linalg.norm(p[i]) * normal[i], np.full(3, np.nan)])]
            for i in drawn
            if found["open"][i] == is_open
        ]
        if points:
            x, y, z = np.concatenate(points).T
            figure.add_trace(go.Scatter3d(x=x, y=y, z=z, mode="lines", line={"color": line, "width": 5}, name=name), row=1, col=2)
    figure.update_scenes(
        aspectmode="data",
        xaxis_title="x_C",
        yaxis_title="y_C",
        zaxis_title="z_C",
        camera={"up": {"x": 0, "y": -1, "z": 0}, "eye": {"x": 1.2, "y": -0.8, "z": -1.6}},
    )
