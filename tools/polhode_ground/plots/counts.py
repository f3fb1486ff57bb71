"""Features, matches, inliers and landmarks over time, the mode behind them, and the time of each step."""

import numpy as np
from matplotlib.patches import Patch

from polhode_ground.common.tables import COST, COUNTS
from polhode_ground.plots import style
from polhode_ground.plots.style import plt

FRAME_SERIES = (("features", "#9aa0a6"), ("matches", style.CAUSAL), ("inliers", style.GOOD))


def _mode_bands(axis, time, modes: list[str]) -> list:
    """Paints each stretch of one mode; returns legend patches."""
    if not modes or len(time) < 2:
        return []
    edges = [0, *[i for i in range(1, len(modes)) if modes[i] != modes[i - 1]], len(modes)]
    step = np.median(np.diff(time))
    for first, end in zip(edges[:-1], edges[1:]):
        axis.axvspan(
            time[first] - step / 2,
            time[end - 1] + step / 2,
            lw=0,
            zorder=0,
            color=style.MODE_COLOURS.get(modes[first], "#ffffff"),
            alpha=0.45,
        )
    return [Patch(color=style.MODE_COLOURS.get(mode, "#ffffff"), alpha=0.45, label=mode) for mode in dict.fromkeys(modes)]


def _lines(axis, time, columns: dict, series, label: str) -> None:
    for name, colour in series:
        if np.isfinite(columns[name]).any():
            axis.plot(time, columns[name], color=colour, lw=1.3, label=name)
    axis.set_ylabel(label)
    axis.set_ylim(bottom=0)


def draw(run, folder, prefix: str = "") -> list:
    """counts.png, from motion.csv where it is there: it tells what the flying estimator had at each frame."""
    motion = run.motions.get("causal") or next(iter(run.motions.values()))
    columns = {name: motion.columns[name] for name in (*COUNTS, *COST)}
    if not any(np.isfinite(values).any() for values in columns.values()):
        return []
    time, label = style.time_axis(motion.seconds)
    figure, axes = plt.subplots(4, 1, sharex=True, figsize=(9, 8.5), height_ratios=[2.4, 1.2, 1, 1])
    patches = _mode_bands(axes[0], time, motion.mode)
    _lines(axes[0], time, columns, FRAME_SERIES, "count in the frame")
    _lines(axes[1], time, columns, [("landmarks", style.SMOOTHED)], "landmarks\nin the map")
    _lines(axes[2], time, columns, [("keyframes", "#6b4c9a")], "keyframes\nin the map")
    axes[3].plot(time, columns["step_us"] / 1e3, ".", ms=3, color=style.BAD)
    axes[3].set_ylabel("step time\n[ms]")
    axes[3].set_ylim(bottom=0)
    axes[3].set_xlabel(label)
    axes[0].set_title("What each frame had to work with", fontsize=11, loc="left")
    handles = axes[0].get_legend_handles_labels()[0] + patches
    figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 7))
    return [style.save(figure, folder, f"{prefix}counts.png")]
