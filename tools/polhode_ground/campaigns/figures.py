"""The report's pictures: curves of the first pose, distributions, and the worst runs' own plots."""

import base64
import io
import pathlib
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from polhode_ground.campaigns.summaries import MEASURES, first_pose_curve, values_of
from polhode_ground.plots import counts, errors, motion, sheet, style
from polhode_ground.plots.style import plt

DISTRIBUTIONS = ("causal_attitude_rms_deg", "smoothed_attitude_rms_deg", "coverage", "silence_turn_deg")  # columns


def embedded(figure: Figure) -> str:
    """A picture as a data address, so that the page needs no other file."""
    octets = io.BytesIO()
    figure.savefig(octets, format="png", dpi=110, metadata={"Software": None})
    plt.close(figure)
    return "data:image/png;base64," + base64.b64encode(octets.getvalue()).decode()


def first_pose(groups: dict[str, list[dict[str, Any]]]) -> str:
    """Share of targets with a first pose over the turn that was seen; a step for each run."""
    figure, axis = plt.subplots(figsize=(7.2, 4.2))
    for number, (name, rows) in enumerate(groups.items()):
        turns, share = first_pose_curve(rows)
        axis.step(
            [*turns, max(row["turn_total_deg"] for row in rows)],
            100 * np.array([*share, share[-1]]),
            where="post",
            label=f"{name} ({len(rows)} runs)",
            color=f"C{number % 10}",
            ls=("-", "--", ":")[number // 10 % 3],
        )
    axis.set_xscale("symlog", linthresh=10)
    axis.set_xlim(0, None)
    axis.set_ylim(0, 102)
    axis.set_xlabel("turn seen by the camera [deg]")
    axis.set_ylabel("runs with a first pose [%]")
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, loc="lower right")
    axis.set_title("First pose (Kaplan-Meier; a sequence that ends without one is censored at its turn)", fontsize=9)
    figure.tight_layout()
    return embedded(figure)


def distributions(groups: dict[str, list[dict[str, Any]]]) -> str:
    """Share of runs up to a value, for the figures that matter most."""
    figure, axes = plt.subplots(2, 2, figsize=(11, 6.6))
    for axis, measure in zip(axes.ravel(), (one for column in DISTRIBUTIONS for one in MEASURES if one.column == column)):
        for number, (name, rows) in enumerate(groups.items()):
            values = np.sort(values_of(rows, measure))
            values = values[np.isfinite(values)]
            if len(values):
                axis.step(
                    [values[0], *values],
                    np.linspace(0, 100 * len(values) / len(rows), len(values) + 1),
                    where="post",
                    label=name,
                    color=f"C{number % 10}",
                    ls=("-", "--", ":")[number // 10 % 3],
                )
        if measure.factor == 1.0:
            axis.set_xscale("log" if "RMS" in measure.title else "symlog")
        axis.set_xlabel(measure.title)
        axis.set_ylabel("share of runs [%]")
        axis.set_ylim(0, 102)
        axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=8)
    figure.tight_layout()
    return embedded(figure)


def of_run(row: dict[str, Any], folder: pathlib.Path) -> list[pathlib.Path]:
    """PNGs of one run: frames with what was followed, errors, rates, counts. Kept between calls; none where the run has gone."""
    from polhode_ground.common.sequence import read_sequence
    from polhode_ground.judge.run import read_run, read_truth

    if folder.is_dir() and any(folder.iterdir()):
        return sorted(folder.iterdir())
    run_folder, sequence_folder = pathlib.Path(row["run_folder"]), pathlib.Path(row["sequence_folder"])
    if not run_folder.is_dir() or not sequence_folder.is_dir():
        return []
    run, sequence = read_run(run_folder), read_sequence(sequence_folder)
    truth = read_truth(sequence)
    style.prepare(folder)
    return sorted(
        [*sheet.draw(run, sequence, folder), *errors.draw(run, truth, folder), *motion.draw(run, truth, folder), *counts.draw(run, folder)]
    )
