"""Features, matches, inliers and landmarks over time, the mode behind them, and the time of each step."""

import numpy as np
from matplotlib.patches import Patch
from plots import style
from plots.style import plt

SERIES = (("features", "#9aa0a6"), ("matches", style.CAUSAL), ("inliers", style.GOOD), ("landmarks", style.SMOOTHED))


def _mode_bands(axis, time, modes: list[str]) -> list:
    """Paints each stretch of one mode; returns legend patches."""
    if not modes or len(time) < 2:
        return []
    edges = [0, *[i for i in range(1, len(modes)) if modes[i] != modes[i - 1]], len(modes)]
    step = np.median(np.diff(time))
    for first, end in zip(edges[:-1], edges[1:]):
        axis.axvspan(time[first] - step / 2, time[end - 1] + step / 2, lw=0, zorder=0,
                     color=style.MODE_COLOURS.get(modes[first], "#ffffff"), alpha=0.45)
    return [Patch(color=style.MODE_COLOURS.get(mode, "#ffffff"), alpha=0.45, label=mode) for mode in dict.fromkeys(modes)]


def draw(run, folder, prefix: str = "") -> list:
    """counts.png, from motion.csv where it is there: it tells what the flying estimator had at each frame."""
    motion = run.motions.get("causal") or next(iter(run.motions.values()))
    columns = {name: motion.columns[name] for name in (*(name for name, _ in SERIES), "keyframes", "step_us")}
    if not any(np.isfinite(values).any() for values in columns.values()):
        return []
    time, label = style.time_axis(motion.seconds)
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(9, 6.5), height_ratios=[2.2, 1])
    for name, colour in SERIES:
        if np.isfinite(columns[name]).any():
            axes[0].plot(time, columns[name], color=colour, lw=1.3, label=name)
    axes[0].set_ylabel("count per frame (landmarks: in the map)")
    axes[0].set_ylim(bottom=0)
    if np.isfinite(columns["keyframes"]).any():
        axes[1].step(time, columns["keyframes"], where="post", color="#6b4c9a", lw=1.3, label="keyframes")
        axes[1].set_ylabel("keyframes")
        axes[1].set_ylim(bottom=0)
    if np.isfinite(columns["step_us"]).any():
        right = axes[1].twinx()
        right.plot(time, columns["step_us"] / 1e3, ".", ms=2.5, color=style.BAD)
        right.set_ylabel("step [ms]", color=style.BAD)
        right.set_ylim(bottom=0)
        right.grid(False)
        axes[1].plot([], [], ".", color=style.BAD, label="step time")
    patches = _mode_bands(axes[0], time, motion.mode)
    axes[1].set_xlabel(label)
    handles = [line for axis in axes for line in axis.get_legend_handles_labels()[0]] + patches
    axes[0].set_title("What each frame had to work with", fontsize=11, loc="left")
    figure.legend(handles=handles, loc="outside upper center", ncols=5)
    return [style.save(figure, folder, f"{prefix}counts.png")]
