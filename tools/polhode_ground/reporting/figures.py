"""Figures over time, by plotly. Long runs are thinned so that the page stays small."""

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from polhode_ground.judge.prediction import judge_prediction
from polhode_ground.judge.run import best_alignment
from polhode_ground.plots import series, style
from polhode_ground.reporting.gather import Material

POINTS_MAX = 1500  # of a line: more than a screen has columns
HEIGHT_PX = {1: 300, 2: 460, 3: 640}
AXES = "xyz"


def _away(stretch: np.ndarray) -> np.ndarray:
    """[N] how far the rows of a stretch [N,K] are from its median; NaN where a row is a break, 0 where all are."""
    finite = np.isfinite(stretch)
    if finite.all():  # numpy's median that passes over NaN takes ten times as long
        return np.abs(stretch - np.median(stretch, axis=0)).max(axis=1)
    return np.abs(stretch - np.nanmedian(stretch, axis=0) if finite.any() else stretch * 0).max(axis=1)


def thinned(seconds: np.ndarray, *columns: np.ndarray) -> list[np.ndarray]:
    """At most about 2 * POINTS_MAX rows: of each stretch its first and its most outlying one, and every break (NaN)."""
    count = len(seconds)
    if count <= POINTS_MAX:
        return [seconds, *columns]
    first = columns[0].reshape(count, -1)
    kept = []
    for rows in np.array_split(np.arange(count), POINTS_MAX):
        kept += [rows[0], rows[int(np.argmax(np.nan_to_num(_away(first[rows]))))], *rows[np.isnan(first[rows, 0])][:1]]
    kept = np.unique(kept)
    return [seconds[kept], *(column[kept] for column in columns)]


def colour(name: str, opacity: float) -> str:
    """'#rrggbb' as rgba()."""
    return f"rgba({', '.join(str(int(name[i : i + 2], 16)) for i in (1, 3, 5))}, {opacity})"


def _stacked(rows: int, titles) -> go.Figure:
    figure = make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing={2: 0.17, 3: 0.1}[rows], subplot_titles=titles)
    figure.update_layout(height=HEIGHT_PX[rows])
    return figure


def laid_out(figure: go.Figure, x_title: str = "time [s]") -> go.Figure:
    figure.update_layout(
        template="plotly_white",
        margin={"l": 60, "r": 15, "t": 40, "b": 40},
        font={"size": 13},
        hovermode="closest",
        legend={"orientation": "h", "yanchor": "top", "y": -0.12 * HEIGHT_PX[3] / figure.layout.height, "x": 0},
    )
    figure.update_annotations(font_size=13, x=0, xanchor="left")
    figure.update_xaxes(title_text=x_title, row=None if not figure._grid_ref else len(figure._grid_ref))
    return figure


def _band(figure, row: int, seconds, value, sigma, kind: str, show: bool) -> None:
    """The band of one sigma, stretch by stretch: a filled line would close across a break."""
    name = f"{style.KIND_NAMES[kind]}, 1 sigma"
    edges = [0, *(np.flatnonzero(np.isnan(value)) + 1), len(value) + 1]
    for begin, end in zip(edges[:-1], edges[1:]):
        part = slice(begin, end - 1)
        good = np.isfinite(value[part]) & np.isfinite(sigma[part])
        if good.sum() < 2:
            continue
        x, low, high = seconds[part][good], (value - sigma)[part][good], (value + sigma)[part][good]
        figure.add_trace(
            go.Scatter(
                x=np.concatenate([x, x[::-1]]),
                y=np.concatenate([high, low[::-1]]).astype(np.float32),
                fill="toself",
                mode="lines",
                line={"width": 0},
                fillcolor=colour(style.KIND_COLOURS[kind], 0.25),
                hoverinfo="skip",
                name=name,
                legendgroup=name,
                showlegend=show,
            ),
            row=row,
            col=1,
        )
        show = False


def _components(found: list[series.Series], names: list[str], truth_name: str) -> go.Figure:
    figure = _stacked(3, names)
    for one in found:
        columns = [one.value, one.sigma] + ([] if one.truth is None else [one.truth])
        seconds, value, sigma, *rest = thinned(one.seconds, *columns)
        for i in range(3):
            _band(figure, i + 1, seconds, value[:, i], sigma, one.kind, i == 0)
            if rest:
                figure.add_trace(
                    go.Scatter(
                        x=seconds,
                        y=rest[0][:, i].astype(np.float32),
                        mode="lines",
                        name=f"{truth_name}, {style.KIND_NAMES[one.kind]}",
                        legendgroup=f"truth{one.kind}",
                        showlegend=i == 0,
                        opacity=0.55,
                        line={"color": style.TRUTH, "width": 5},
                    ),
                    row=i + 1,
                    col=1,
                )
            figure.add_trace(
                go.Scatter(
                    x=seconds,
                    y=value[:, i].astype(np.float32),
                    mode="markers" if one.kind == "causal" else "lines",
                    name=style.KIND_NAMES[one.kind],
                    legendgroup=one.kind,
                    showlegend=i == 0,
                    marker={"size": 3, "color": style.KIND_COLOURS[one.kind]},
                    line={"color": style.KIND_COLOURS[one.kind], "width": 1.5},
                ),
                row=i + 1,
                col=1,
            )
    for i in range(3):
        values = [one.value[:, i] for one in found] + [one.truth[:, i] for one in found if one.truth is not None]
        figure.update_yaxes(range=style.robust_limits(np.empty(0), values), row=i + 1, col=1)
    return laid_out(figure)


def rates(material: Material) -> go.Figure | None:
    run = material.run
    found = [one for one in (series.rate_series(run, kind, material.truth) for kind in run.motions) if one]
    return _components(found, [f"w_{axis} [deg/s]" for axis in AXES], "truth") if found else None


def velocity(material: Material) -> go.Figure | None:
    run = material.run
    found = [one for one in (series.velocity_series(run, kind, material.truth) for kind in run.motions) if one]
    unit = "mm/s" if material.truth is not None or series.velocity_in_metres(run) else "thousandths of a map unit/s"
    return _components(found, [f"v_{axis} [{unit}]" for axis in AXES], "truth at its origin") if found else None


def errors(material: Material) -> go.Figure | None:
    if material.truth is None:
        return None
    found = [one for one in (series.error_series(material.run, kind, material.truth) for kind in material.run.motions) if one]
    if not found:
        return None
    figure = _stacked(3, ["attitude [deg]", "position, scale as published [% of range]", "position, scale fitted [% of range]"])
    for one in found:
        name, line = style.KIND_NAMES[one.kind], style.KIND_COLOURS[one.kind]
        pairs = (
            (one.attitude_deg, one.sigma_attitude_deg),
            (one.position, one.sigma_position),
            (one.shape_position, one.sigma_shape_position),
        )
        for row, (error, sigma) in enumerate(pairs, 1):
            seconds, error, sigma = thinned(one.seconds, error, sigma)
            for values, dash, label in ((error, None, f"{name}, error"), (sigma, "dash", f"{name}, its 1 sigma")):
                figure.add_trace(
                    go.Scatter(
                        x=seconds,
                        y=values.astype(np.float32),
                        mode="lines",
                        line={"color": line, "dash": dash, "width": 1.5},
                        name=label,
                        legendgroup=label,
                        showlegend=row == 1,
                    ),
                    row=row,
                    col=1,
                )
    figure.update_yaxes(type="log", dtick=1, exponentformat="none")
    return laid_out(figure)


def timeline(material: Material) -> go.Figure:
    """Modes as coloured stretches, events as marks with their text."""
    motion = material.run.motions.get("causal") or next(iter(material.run.motions.values()))
    figure, seconds = go.Figure(), motion.seconds
    modes = motion.mode or ["unknown"] * len(seconds)
    step = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 1.0
    edges = [0, *[i for i in range(1, len(modes)) if modes[i] != modes[i - 1]], len(modes)]
    shown = set()
    for first, end in zip(edges[:-1], edges[1:]):
        mode, length = modes[first], seconds[end - 1] - seconds[first] + step
        figure.add_trace(
            go.Bar(
                x=[length],
                base=[seconds[first] - step / 2],
                y=["mode"],
                orientation="h",
                name=mode,
                legendgroup=mode,
                showlegend=mode not in shown,
                marker={"color": style.MODE_COLOURS.get(mode, "#cccccc"), "line": {"width": 0}},
                hovertemplate=f"{mode}: frames {first} to {end - 1}<extra></extra>",
            )
        )
        shown.add(mode)
    if material.events:
        times = np.array([series.time_ns_of(event) - int(motion.timestamp_ns[0]) for event in material.events]) * 1e-9
        figure.add_trace(
            go.Scatter(
                x=times,
                y=["events"] * len(times),
                mode="markers",
                name="event (touch for its text)",
                marker={"symbol": "line-ns-open", "size": 16, "color": "#333333"},
                text=[event.text for event in material.events],
                hovertemplate="%{x:.1f} s: %{text}<extra></extra>",
            )
        )
    figure.update_layout(height=HEIGHT_PX[1] - 80, barmode="overlay", bargap=0.3)
    figure = laid_out(figure)
    figure.update_layout(legend={"y": 1.02, "yanchor": "bottom"})
    return figure


def counts(material: Material) -> go.Figure | None:
    motion = material.run.motions.get("causal") or next(iter(material.run.motions.values()))
    groups = (
        (("features", "#7a8087"), ("matches", style.CAUSAL), ("inliers", style.GOOD)),
        (("landmarks", style.SMOOTHED), ("keyframes", "#6b4c9a")),
    )
    if not any(np.isfinite(motion.columns[name]).any() for group in groups for name, _ in group):
        return None
    figure = _stacked(2, ["points in each frame", "landmarks and keyframes in the map"])
    for row, group in enumerate(groups, 1):
        for name, line in group:
            seconds, values = thinned(motion.seconds, motion.columns[name])
            figure.add_trace(go.Scatter(x=seconds, y=values, mode="lines", name=name, line={"color": line, "width": 1.5}), row=row, col=1)
    figure.update_yaxes(rangemode="tozero")
    return laid_out(figure)


def step_times(material: Material) -> go.Figure | None:
    motion = material.run.motions.get("causal") or next(iter(material.run.motions.values()))
    if not np.isfinite(motion.columns["step_us"]).any():
        return None
    seconds, values = thinned(motion.seconds, motion.columns["step_us"] / 1e3)
    figure = go.Figure(
        go.Scatter(
            x=seconds, y=values, mode="markers", marker={"size": 4, "color": style.BAD}, name="time of each step [ms]", showlegend=True
        )
    )
    figure.update_layout(height=HEIGHT_PX[1])
    figure.update_yaxes(title_text="ms", rangemode="tozero")
    return laid_out(figure)


def prediction(material: Material) -> go.Figure | None:
    """Rates ahead with their band, and how wide the cone of the attitude grows; errors where the truth goes on."""
    rows = [row for row in material.model.get("prediction") or [] if row.get("w_T_rad_s")]
    if len(rows) < 2:
        return None
    ahead = np.array([row["ahead_s"] for row in rows])
    figure = _stacked(2, ["predicted rate, target's axes [deg/s]", "attitude: cone of one sigma [deg]"])
    w, sigma = np.degrees([row["w_T_rad_s"] for row in rows]), np.degrees([row.get("sigma_rate_rad_s") or np.nan for row in rows])
    for i, line in enumerate(("#0b4f9e", "#2ca02c", "#9467bd")):
        figure.add_trace(
            go.Scatter(
                x=ahead,
                y=w[:, i],
                error_y={"type": "data", "array": sigma, "thickness": 1},
                mode="markers",
                name=f"w_{AXES[i]}",
                marker={"color": line},
            ),
            row=1,
            col=1,
        )
    cone = np.degrees([row.get("sigma_att_rad") or np.nan for row in rows])
    figure.add_trace(
        go.Scatter(
            x=np.concatenate([ahead, ahead[::-1]]),
            y=np.concatenate([cone, -cone[::-1]]),
            fill="toself",
            mode="lines",
            line={"width": 0},
            fillcolor=colour(style.SMOOTHED, 0.25),
            name="1 sigma about the prediction",
        ),
        row=2,
        col=1,
    )
    aligned = best_alignment(material.run, material.truth) if material.truth is not None else None
    judged = judge_prediction(material.run.folder / "motion_model.json", aligned) or []
    if len([one for one in judged if one["ahead_s"] > 0]):
        figure.add_trace(
            go.Scatter(
                x=[one["ahead_s"] for one in judged],
                y=[one["attitude_deg"] for one in judged],
                mode="markers",
                name="error",
                marker={"color": style.TRUTH},
            ),
            row=2,
            col=1,
        )
    return laid_out(figure, "seconds after the last frame of the fit")
