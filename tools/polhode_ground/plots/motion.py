"""Angular and linear velocity against the truth, with one-sigma bands, as in the paper's figures."""

import numpy as np

from polhode_ground.common.tables import join
from polhode_ground.judge import period
from polhode_ground.plots import series, style
from polhode_ground.plots.style import plt

FIT_MIN = 0.02  # a sine smaller than this part of the mean speed is not drawn
CYCLES_MIN = 0.75


def _truth_lines(axis, time, truth, series_list, factor: float, i: int) -> None:
    """The truth as it is sampled; where it differs by the estimate's origin, each file has its own."""
    if truth is not None:
        axis.plot(time, truth[:, i], color=style.TRUTH, lw=1.6, label="truth", zorder=2)
        return
    for one, dashes in zip(series_list, ("-", ":")):
        if one.truth is not None:
            axis.plot(
                one.seconds * factor,
                one.truth[:, i],
                dashes,
                color=style.TRUTH,
                lw=1.5,
                zorder=2,
                label=f"truth at the origin of {style.KIND_NAMES[one.kind]}",
            )


def _panel(axis, one: series.Series, factor: float, i: int, sine: bool) -> None:
    """One component of one file: dots with a band of one sigma, which breaks where the series does."""
    colour, name = style.KIND_COLOURS[one.kind], style.KIND_NAMES[one.kind]
    time, value = one.seconds * factor, one.value[:, i]
    axis.fill_between(time, value - one.sigma, value + one.sigma, color=colour, alpha=0.25, lw=0, zorder=1, label=f"{name}, 1 sigma")
    axis.plot(time, value, ".", ms=3.2, color=colour, label=name, zorder=3)
    kept = np.isfinite(value)
    if not sine or one.kind != "smoothed" or kept.sum() < period.SAMPLES_MIN:
        return
    seconds = one.seconds[kept]
    fit = period.fit_sine(seconds, value[kept])
    if fit and fit["amplitude"] > FIT_MIN * np.linalg.norm(one.value[kept], axis=1).mean() and fit["cycles"] > CYCLES_MIN:
        axis.plot(
            seconds * factor, period.sine_curve(fit, seconds, seconds[0]), "--", lw=1, color=colour, label=f"{name}, sine fit", zorder=4
        )


def _figure(found: list[series.Series], truth_seconds, truth_values, labels, unit: str, title: str, sine: bool):
    """Three stacked panels over one time axis."""
    span = np.concatenate([one.seconds for one in found] + ([truth_seconds] if truth_values is not None else []))
    factor = 1 / 60 if np.nanmax(span) > style.MINUTES_FROM_S else 1.0
    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(9, 7.5))
    for i, axis in enumerate(axes):
        _truth_lines(axis, truth_seconds * factor, truth_values, found, factor, i)
        for one in found:
            _panel(axis, one, factor, i, sine)
        references = [truth_values[:, i]] if truth_values is not None else [one.truth[:, i] for one in found if one.truth is not None]
        values = [one.value[:, i] for one in found]
        axis.set_ylim(*style.robust_limits(np.concatenate(references) if references else np.empty(0), values))
        hidden = sum(style.count_outside(axis, value) for value in values)
        axis.set_ylabel(f"{labels[i]} [{unit}]" + (f"\n({hidden} beyond)" if hidden else ""))
    axes[-1].set_xlabel("time [min]" if factor != 1.0 else "time [s]")
    style.head(figure, axes, title)
    return figure


def draw(run, truth, folder, prefix: str = "") -> list:
    """rates.png and velocity.png; what a run does not have is not drawn."""
    paths = []
    overlap = truth is not None and all(len(join(motion, truth)[0]) for motion in run.motions.values())
    truth = truth if overlap else None
    truth_seconds = (truth.timestamp_ns - series.start_ns(run)) * 1e-9 if truth is not None else np.empty(0)
    rates = [one for one in (series.rate_series(run, kind, truth) for kind in run.motions) if one]
    if rates:
        values = np.degrees(truth.w_T) if truth is not None and np.isfinite(truth.w_T).any() else None
        axes_of = "truth's" if truth is not None else "estimate's own"
        figure = _figure(
            rates,
            truth_seconds,
            values,
            ["w_x", "w_y", "w_z"],
            "deg/s",
            f"Angular velocity of the target, in the {axes_of} body axes",
            sine=True,
        )
        paths.append(style.save(figure, folder, f"{prefix}rates.png"))
    velocities = [one for one in (series.velocity_series(run, kind, truth) for kind in run.motions) if one]
    if velocities:
        known = series.velocity_in_metres(run)
        unit = "mm/s" if known or truth is not None else "map units/s / 1000"
        note = "" if known else ", scale taken from the truth" if truth is not None else ", scale unknown"
        figure = _figure(
            velocities,
            truth_seconds,
            None,
            ["v_x", "v_y", "v_z"],
            unit,
            f"Velocity of the target's origin in the camera frame{note}",
            sine=False,
        )
        paths.append(style.save(figure, folder, f"{prefix}velocity.png"))
    return paths
