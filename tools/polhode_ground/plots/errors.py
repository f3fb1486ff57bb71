"""Attitude and position errors over time against the truth, with the published sigmas."""

import numpy as np

from polhode_ground.judge import metrics
from polhode_ground.plots import series, style
from polhode_ground.plots.style import plt


def _curve(axis, time, error, sigma, kind: str, sigma_name: str) -> None:
    colour, name = style.KIND_COLOURS[kind], style.KIND_NAMES[kind]
    rmse = metrics.rms(error[np.isfinite(error)])
    axis.plot(time, error, ".-", ms=3.5, lw=0.7, color=colour, label=name, zorder=3)
    axis.axhline(rmse, color=colour, lw=1, ls=":", zorder=2)
    axis.annotate(
        f"RMSE {rmse:.3g}",
        (1.005, rmse),
        xycoords=("axes fraction", "data"),
        color=colour,
        fontsize=8,
        va="bottom" if kind == "causal" else "top",
        annotation_clip=False,
    )
    if np.isfinite(sigma).any():
        axis.plot(time, sigma, color=colour, lw=1.2, ls="--", label=f"{name}, {sigma_name}", zorder=4)


def draw(run, truth, folder, prefix: str = "") -> list:
    """attitude_error.png: attitude [deg], position with its scale and without [% of range]; a line where a new T begins."""
    if truth is None:
        return []
    found = [one for one in (series.error_series(run, kind, truth) for kind in run.motions) if one is not None]
    if not found:
        return []
    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(9, 9))
    for one in found:
        seconds, label = style.time_axis(one.seconds)
        _curve(axes[0], seconds, one.attitude_deg, one.sigma_attitude_deg, one.kind, "published 1 sigma")
        _curve(axes[1], seconds, one.position, one.sigma_position, one.kind, "published 1 sigma")
        _curve(axes[2], seconds, one.shape_position, one.sigma_shape_position, one.kind, "1 sigma without the scale's")
        factor = 1 / 60 if label.endswith("[min]") else 1.0
        for start_s in one.target_frame_starts_s if one.kind == "causal" else []:
            for axis in axes:
                axis.axvline(start_s * factor, color=style.BAD, lw=1, ls="-.", zorder=1)
        axes[2].set_xlabel(label)
    labels = ("attitude error [deg]", "position error, scale as\npublished [% of range]", "position error, scale\nfitted [% of range]")
    for axis, label in zip(axes, labels):
        style.plain_log_axis(axis, label)
    style.head(figure, axes, "Errors after one constant rotation and offset for each target frame T")
    return [style.save(figure, folder, f"{prefix}attitude_error.png")]
