"""The cloud in three dimensions, with the body's axes, planes, surface and the camera's path around it."""

import pathlib

import numpy as np
import plotly.graph_objects as go

from polhode_ground.plots import series, style
from polhode_ground.reporting.gather import Material

POINTS_MAX = 12000
PATH_MAX = 2000
AXIS_COLOURS = {"x": "#d62728", "y": "#2ca02c", "z": "#1f77b4"}


def _added(material: Material, count: int) -> np.ndarray:
    """[N] bool: points that completion made."""
    from polhode_ground.judge.shape import load_ply, property_of

    path = material.run.folder / "cloud.ply"
    marks = property_of(load_ply(path), "added", count) if path.exists() else None
    return np.zeros(count, bool) if marks is None else marks > 0


def surfaces(folder: pathlib.Path) -> list[go.Mesh3d]:
    """surface.ply, what was measured and what was completed apart; [] where there is none."""
    from polhode_ground.judge.shape import load_ply, property_of

    path = folder / "surface.ply"
    mesh = load_ply(path) if path.exists() else None
    if mesh is None or len(getattr(mesh, "faces", ())) == 0:
        return []
    corners, faces = np.asarray(mesh.vertices, dtype=np.float32), np.asarray(mesh.faces)
    added = property_of(mesh, "added", len(corners))
    guessed = np.zeros(len(faces), bool) if added is None else (added[faces] > 0).any(axis=1)
    kinds = (
        [("surface", ~guessed, "#8fa6bd")]
        if added is None
        else [("surface, measured", ~guessed, "#8fa6bd"), ("surface, completed", guessed, style.BAD)]
    )
    return [
        go.Mesh3d(
            x=corners[:, 0],
            y=corners[:, 1],
            z=corners[:, 2],
            i=faces[rows, 0],
            j=faces[rows, 1],
            k=faces[rows, 2],
            color=colour,
            flatshading=True,
            name=name,
            showlegend=True,
            hoverinfo="name",
            visible="legendonly",
        )
        for name, rows, colour in kinds
        if rows.any()
    ]


def _segments(name: str, points: np.ndarray, line: dict) -> go.Scatter3d:
    return go.Scatter3d(x=points[:, 0], y=points[:, 1], z=points[:, 2], mode="lines", name=name, line=line)


def _plane_corners(plane: dict) -> np.ndarray:
    centre, (a, b) = np.array(plane["centre_T"]), np.array(plane["extent_axes_T"])
    half_a, half_b = np.array(plane["extents"]) / 2
    return np.array([centre + s * half_a * a + t * half_b * b for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def scene(material: Material) -> go.Figure | None:
    found = series.cloud_and_path(material.run, None)  # in the estimate's own frame, which shape.json is in
    if found is None or len(found[0]) == 0:
        return None
    points, camera, _, _, _, unit = found
    added, figure = _added(material, len(points)), go.Figure()
    keep = np.arange(0, len(points), max(1, len(points) // POINTS_MAX))
    for name, rows, colour in (("cloud, measured", keep[~added[keep]], "#3b5b7a"), ("cloud, completed", keep[added[keep]], style.BAD)):
        if len(rows):
            figure.add_trace(
                go.Scatter3d(
                    x=points[rows, 0],
                    y=points[rows, 1],
                    z=points[rows, 2],
                    mode="markers",
                    name=name,
                    marker={"size": 1.8, "color": colour},
                )
            )
    shape = material.shape.get("shape") or {}
    for number, plane in enumerate(shape.get("planes") or [], 1):
        corners = _plane_corners(plane)
        figure.add_trace(
            go.Mesh3d(
                x=corners[:, 0],
                y=corners[:, 1],
                z=corners[:, 2],
                i=[0, 0],
                j=[1, 2],
                k=[2, 3],
                opacity=0.25,
                color="#e0a030",
                name="planes",
                legendgroup="planes",
                showlegend=number == 1,
                hoverinfo="name",
            )
        )
    figure.add_traces(surfaces(material.run.folder))
    size = float(np.percentile(np.linalg.norm(points - np.median(points, axis=0), axis=1), 95))
    origin = np.array(shape.get("centroid_T") or np.median(points, axis=0), dtype=float)
    for name, direction in (shape.get("axes") or {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}).items():
        figure.add_trace(
            _segments(
                f"{name} axis", np.array([origin, origin + 1.3 * size * np.array(direction)]), {"color": AXIS_COLOURS[name], "width": 6}
            )
        )
    path = _segments("camera's path", camera[:: max(1, len(camera) // PATH_MAX)].astype(np.float32), {"color": "#888888", "width": 3})
    path.visible = "legendonly"  # it is far away: with it the body is a dot
    figure.add_trace(path)
    bounds = {f"{axis}axis": {"title": f"{axis} [{unit}]"} for axis in "xyz"}
    figure.update_layout(
        height=560,
        template="plotly_white",
        margin={"l": 0, "r": 0, "t": 10, "b": 0},
        font={"size": 12},
        scene={"aspectmode": "data", "dragmode": "turntable", **bounds},
        legend={"orientation": "h", "y": -0.02, "itemsizing": "constant"},
    )
    return figure
