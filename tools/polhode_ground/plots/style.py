"""Colours, fonts and axes common to all pictures."""

import pathlib

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker

from polhode_ground.common.errors import BadInput

# As in the paper: blue for what was estimated, red for the truth. Distinct in gray and for colour-blind eyes.
CAUSAL = "#7fb2e5"
SMOOTHED = "#0b4f9e"
TRUTH = "#d62728"
GOOD = "#2ca02c"
BAD = "#ff7f0e"
KIND_COLOURS = {"causal": CAUSAL, "smoothed": SMOOTHED}
KIND_NAMES = {"causal": "causal (flies)", "smoothed": "smoothed"}
MODE_COLOURS = {"IDLE": "#dddddd", "ACQUIRING": "#f2c14e", "TRACKING": "#cfe8cf", "COASTING": "#b9d4ee", "LOST": "#f4a6a6"}
DPI = 130
MINUTES_FROM_S = 1200  # longer runs are drawn in minutes


def prepare(folder: pathlib.Path) -> None:
    """Sets the defaults and makes the folder."""
    matplotlib.rcParams.update(
        {
            "figure.dpi": DPI,
            "savefig.dpi": DPI,
            "font.size": 10,
            "axes.grid": True,
            "grid.color": "#e3e3e3",
            "grid.linewidth": 0.6,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.axisbelow": True,
            "legend.frameon": False,
            "axes.xmargin": 0.01,
            "figure.constrained_layout.use": True,
        }
    )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise BadInput(f"{folder}: {problem.strerror}") from None


def save(figure, folder: pathlib.Path, name: str) -> pathlib.Path:
    from polhode_ground.common.whole_file import MARK, beside

    path = folder / name
    try:
        with beside(path) as part:
            figure.savefig(part, metadata={"Software": MARK})
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None
    finally:
        plt.close(figure)
    return path


def head(figure, axes, title: str) -> None:
    """Title and one legend for the whole figure, above the axes so that they hide nothing."""
    np.ravel(axes)[0].set_title(title, fontsize=11, loc="left")
    entries = {}
    for axis in np.ravel(axes):
        for handle, label in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    if entries:
        figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=4 if len(entries) <= 4 else 3)


def time_axis(seconds: np.ndarray) -> tuple[np.ndarray, str]:
    """Times in the unit that suits their span, and the axis label."""
    if seconds.size and seconds.max() > MINUTES_FROM_S:
        return seconds / 60, "time [min]"
    return seconds, "time [s]"


def robust_limits(reference: np.ndarray, others: list[np.ndarray], margin: float = 0.25) -> tuple[float, float]:
    """Limits that show all of the reference and the bulk of the others: 98 of 100 values, but no wild outlier."""
    pool = [values[np.isfinite(values)] for values in (reference, *others)]
    bounds = [np.percentile(values, [0, 100] if i == 0 else [1, 99]) for i, values in enumerate(pool) if len(values)]
    if not bounds:
        return -1.0, 1.0
    low, high = min(b[0] for b in bounds), max(b[1] for b in bounds)
    size = max(high - low, 1e-3 * max(abs(low), abs(high)), 1e-9)
    return low - margin * size, high + margin * size


def plain_log_axis(axis, label: str) -> None:
    """Logarithmic axis whose ticks are plain numbers."""
    axis.set_yscale("log")
    axis.set_ylabel(label)
    plain = matplotlib.ticker.FuncFormatter(lambda value, _: f"{value:g}")
    axis.yaxis.set_major_formatter(plain)
    low, high = axis.get_ylim()
    minor = plain if high / low < 30 else matplotlib.ticker.NullFormatter()
    axis.yaxis.set_minor_locator(matplotlib.ticker.LogLocator(subs=(2, 3, 5)))
    axis.yaxis.set_minor_formatter(minor)
    axis.tick_params(which="minor", labelsize=8)
    axis.grid(which="minor", alpha=0.5)


def count_outside(axis, values: np.ndarray) -> int:
    """How many finite values lie beyond the axis' limits."""
    low, high = axis.get_ylim()
    return int(np.sum((values < low) | (values > high)))
