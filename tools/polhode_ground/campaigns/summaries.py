"""From rows of runs to a table: distributions with bootstrap intervals, curves of the first pose, paired differences.

Scenes are what is drawn at random, so they are what is drawn again for an interval. "Never" is infinite where less is
better, so that a run that never acquires counts in every quantile.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import CensoredData, binomtest, ecdf, wilcoxon

from polhode_ground.campaigns.predictions import AHEAD_S

RESAMPLES = 2000
SEED = 1
INTERVAL = (2.5, 97.5)
# Fewer scenes have no interval worth a name.
SCENES_MIN = 5
# Turns [deg] at which the curve of the first pose is read.
TURNS_DEG = (5, 10, 20, 45, 90, 180, 360)


@dataclass(frozen=True)
class Measure:
    """A column of the runs' table and how it is summed up: "share" of runs, "mean", "median" (with the 90th percentile) or "sum"."""

    title: str
    column: str
    how: str
    better: int = -1  # -1: less, +1: more, 0: neither
    factor: float = 1.0
    layout: str = "{:.3g}"
    never: float | None = None  # what stands for a run without a value; None: it is left out, and the count says so


NEVER = float("inf")
MEASURES = (
    Measure("target acquired [% of runs]", "acquired", "share", 1, 100, "{:.0f}"),
    Measure("first pose after a turn of [deg]", "first_pose_turn_deg", "median", -1, 1, "{:.1f}", NEVER),
    Measure("first pose at frame", "first_pose_frame", "median", -1, 1, "{:.0f}", NEVER),
    Measure("first pose after [s]", "first_pose_s", "median", -1, 1, "{:.1f}", NEVER),
    Measure("depth sign decidable [% of runs]", "decidable", "share", 0, 100, "{:.0f}"),
    Measure("decidable after a turn of [deg]", "limit_turn_deg", "median", 0, 1, "{:.1f}"),
    Measure("acquired, of the decidable [% of runs]", "acquired_of_decidable", "share", 1, 100, "{:.0f}"),
    Measure("first pose after the limit [frames]", "first_pose_after_limit_frames", "median", -1, 1, "{:.0f}"),
    Measure("frames with a pose [%]", "coverage", "mean", 1, 100, "{:.1f}", 0.0),
    Measure("frames with a pose from the first on [%]", "coverage_after_first", "mean", 1, 100, "{:.1f}", 0.0),
    Measure("longest silence [deg of turn]", "silence_turn_deg", "median", -1, 1, "{:.1f}"),
    Measure("longest silence [frames]", "silence_frames", "median", -1, 1, "{:.0f}"),
    Measure("longest silence [s]", "silence_s", "median", -1, 1, "{:.1f}"),
    Measure("attitude RMS, causal [deg]", "causal_attitude_rms_deg", "median"),
    Measure("attitude RMS, smoothed [deg]", "smoothed_attitude_rms_deg", "median"),
    Measure("rate RMS, causal [deg/s]", "causal_rate_rms_deg_s", "median"),
    Measure("rate RMS, smoothed [deg/s]", "smoothed_rate_rms_deg_s", "median"),
    Measure("mean rate off, smoothed [%]", "smoothed_rate_mean_error_percent", "median"),
    Measure("position RMS, causal [% of range]", "causal_position_rms_percent", "median"),
    Measure("position RMS, smoothed [% of range]", "smoothed_position_rms_percent", "median"),
    Measure("attitude inside its 95 % bound, causal [%]", "causal_attitude_in_95", "mean", 1, 100, "{:.1f}"),
    Measure("attitude inside its 99 % bound, causal [%]", "causal_attitude_in_99", "mean", 1, 100, "{:.1f}"),
    Measure("attitude inside its 95 % bound, smoothed [%]", "smoothed_attitude_in_95", "mean", 1, 100, "{:.1f}"),
    Measure("attitude inside its 99 % bound, smoothed [%]", "smoothed_attitude_in_99", "mean", 1, 100, "{:.1f}"),
    Measure("position inside its 95 % bound, causal [%]", "causal_position_in_95", "mean", 1, 100, "{:.1f}"),
    Measure("position inside its 99 % bound, causal [%]", "causal_position_in_99", "mean", 1, 100, "{:.1f}"),
    Measure("position inside its 95 % bound, smoothed [%]", "smoothed_position_in_95", "mean", 1, 100, "{:.1f}"),
    Measure("position inside its 99 % bound, smoothed [%]", "smoothed_position_in_99", "mean", 1, 100, "{:.1f}"),
    Measure("poses judged, causal [frames]", "causal_attitude_judged_frames", "sum", 0, 1, "{:.0f}"),
    Measure("attitude beyond its 99 % bound, causal [frames]", "causal_attitude_beyond_99_frames", "sum", -1, 1, "{:.0f}"),
    Measure("position beyond its 99 % bound, causal [frames]", "causal_position_beyond_99_frames", "sum", -1, 1, "{:.0f}"),
    Measure("attitude beyond its 99 % bound, smoothed [frames]", "smoothed_attitude_beyond_99_frames", "sum", -1, 1, "{:.0f}"),
    Measure("position beyond its 99 % bound, smoothed [frames]", "smoothed_position_beyond_99_frames", "sum", -1, 1, "{:.0f}"),
    Measure("rate inside its 95 % bound, causal [%]", "causal_rate_in_95", "mean", 1, 100, "{:.1f}"),
    Measure("rate inside its 95 % bound, smoothed [%]", "smoothed_rate_in_95", "mean", 1, 100, "{:.1f}"),
    Measure("NEES of attitude over 3, causal (1 is right)", "causal_nees", "median", 0),
    Measure("inside the 95 % ellipsoid, causal [%]", "causal_nees_in_95", "mean", 0, 100, "{:.1f}"),
    *(
        Measure(f"NEES of points predicted {seconds} s ahead over 3 (1 is right)", f"predicted_nees_{seconds}_s", "median", 0)
        for seconds in AHEAD_S
    ),
    *(
        Measure(f"points predicted {seconds} s ahead beyond 99 % [%]", f"predicted_beyond_99_{seconds}_s", "mean", -1, 100, "{:.1f}")
        for seconds in AHEAD_S
    ),
    Measure("depth-reversed, causal [runs]", "causal_depth_reversed", "sum", -1, 1, "{:.0f}"),
    Measure("depth-reversed, smoothed [runs]", "smoothed_depth_reversed", "sum", -1, 1, "{:.0f}"),
    Measure("over 5 deg off with 2 deg reported, causal [frames]", "causal_frames_wrong_confident", "sum", -1, 1, "{:.0f}"),
    Measure("over 5 deg off with 2 deg reported, smoothed [frames]", "smoothed_frames_wrong_confident", "sum", -1, 1, "{:.0f}"),
    Measure("poses in several target frames T [runs]", "causal_begun_anew", "sum", -1, 1, "{:.0f}"),
    Measure("cloud to mesh RMSE [% of size]", "cloud_rmse_percent", "median"),
    Measure("faults: good frames with a pose [%]", "faults_coverage_of_good", "mean", 1, 100, "{:.1f}"),
    Measure("faults: wrong poses of bad frames", "faults_wrong_poses", "sum", -1, 1, "{:.0f}"),
    Measure("faults: miscounted", "faults_miscounted", "sum", -1, 1, "{:.0f}"),
    Measure("processor time a frame, alone [ms]", "cost_cpu_ms_a_frame", "median"),
    Measure("longest step, processor time, alone [ms]", "cost_step_cpu_longest_ms", "median"),
    Measure("peak resident memory, alone [MB]", "cost_peak_resident_mb", "median", -1, 1, "{:.0f}"),
)


def values_of(rows: list[dict[str, Any]], measure: Measure) -> np.ndarray:
    """[N] of the runs in order, in the measure's unit; NaN where a run has no value and none stands for it."""
    missing = np.nan if measure.never is None else measure.never
    return np.array([missing if row.get(measure.column) is None else measure.factor * float(row[measure.column]) for row in rows])


def _quantile(values: np.ndarray, percent: float, axis: int | None = None) -> Any:
    """A value of the sample, so that never stays never."""
    return np.percentile(values, percent, axis=axis, method="inverted_cdf")


def _resampled(values: np.ndarray) -> np.ndarray:
    """[RESAMPLES,N] drawn again, the same way for every measure of equally many values."""
    return values[np.random.default_rng([SEED, len(values)]).integers(len(values), size=(RESAMPLES, len(values)))]


def _interval(samples: np.ndarray) -> list[float]:
    return [float(_quantile(samples, percent)) for percent in INTERVAL]


def _share_interval(values: np.ndarray, measure: Measure) -> list[float]:
    """Of a share of runs, by the binomial distribution (Clopper and Pearson): all of them say something of those to come."""
    found = binomtest(int(np.sum(values > 0)), len(values)).proportion_ci(0.95, method="exact")
    return [measure.factor * float(found.low), measure.factor * float(found.high)]


CENTRES = {
    "share": lambda values, axis=None: values.mean(axis=axis),
    "mean": lambda values, axis=None: values.mean(axis=axis),
    "median": lambda values, axis=None: _quantile(values, 50, axis),
    "sum": lambda values, axis=None: values.sum(axis=axis),
}


def summary(rows: list[dict[str, Any]], measure: Measure) -> dict[str, Any] | None:
    """{count, of, centre, low, high, p90, worst}; None where no run has a value. Worst is by the measure's better side."""
    values = values_of(rows, measure)
    known = values[~np.isnan(values)]
    if len(known) == 0:
        return None
    interval = _share_interval(known, measure) if measure.how == "share" else _interval(CENTRES[measure.how](_resampled(known), axis=1))
    low, high = interval if len(known) >= SCENES_MIN else (None, None)
    bad_side = (10, 0) if measure.better > 0 else (90, 100)
    return {
        "count": len(known),
        "of": len(values),
        "centre": float(CENTRES[measure.how](known)),
        "low": low,
        "high": high,
        "p90": float(_quantile(known, bad_side[0])),
        "worst": float(_quantile(known, bad_side[1])),
    }


def first_pose_curve(rows: list[dict[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
    """(turns [deg], share of the targets that have had a pose by then), Kaplan-Meier: a sequence that ends without a pose
    is censored at its own total turn."""
    acquired = [bool(row["acquired"]) for row in rows]
    turns = [float(row["first_pose_turn_deg"] if has else row["turn_total_deg"]) for row, has in zip(rows, acquired)]
    has = np.array(acquired)
    if not has.any():
        return np.array([0.0, max(turns)]), np.zeros(2)
    data = CensoredData(np.array(turns)[has], right=np.array(turns)[~has])
    curve = ecdf(data).cdf
    return np.concatenate([[0.0], curve.quantiles]), np.concatenate([[0.0], curve.probabilities])


def share_by_turn(rows: list[dict[str, Any]], turn_deg: float) -> float | None:
    """The curve's value at a turn; None beyond the last sequence's turn."""
    if turn_deg > max(row["turn_total_deg"] for row in rows):
        return None
    turns, share = first_pose_curve(rows)
    return float(share[np.searchsorted(turns, turn_deg, side="right") - 1])


def pairs(base: list[dict[str, Any]], new: list[dict[str, Any]]) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Runs of the very same sequence in a setting of the same name in both."""

    def place(row: dict[str, Any]) -> tuple[str, str]:
        return row["sequence_key"], row["setting"]

    at = {place(row): row for row in base}
    return [(at[place(row)], row) for row in new if place(row) in at]


def paired(base: list[dict[str, Any]], new: list[dict[str, Any]], measure: Measure) -> dict[str, Any] | None:
    """New less base over the runs in which both have a value: mean difference with its interval, how many are better and
    worse, Wilcoxon's signed-rank probability. A run that has a pose in one only is better or worse, and in no mean."""
    a, b = values_of(base, measure), values_of(new, measure)
    either = ~(np.isnan(a) & np.isnan(b))
    if not either.any():
        return None
    lacking = -NEVER if measure.better > 0 else NEVER
    a, b = (np.where(np.isnan(values), lacking, values)[either] for values in (a, b))
    both = np.isfinite(a) & np.isfinite(b)
    difference = b[both] - a[both]
    gain = np.where(a == b, 0, np.where(b > a, 1, -1)) * measure.better
    judged = measure.better != 0  # where neither more nor less is better nobody can say
    result: dict[str, Any] = {
        "pairs": int(both.sum()),
        "better": int((gain > 0).sum()) if judged else None,
        "worse": int((gain < 0).sum()) if judged else None,
        "mean": None,
        "low": None,
        "high": None,
        "probability": None,
    }
    if len(difference):
        low, high = _interval(_resampled(difference).mean(axis=1)) if len(difference) >= SCENES_MIN else (None, None)
        result |= {
            "mean": float(difference.mean()),
            "low": low,
            "high": high,
            "probability": float(wilcoxon(difference).pvalue) if np.any(difference != 0) else 1.0,
        }
    return result


def badness(row: dict[str, Any]) -> tuple[Any, ...]:
    """Sorts runs from worst to best: confidently wrong, reversed, never acquired, silent, off."""
    return (
        -row["causal_frames_wrong_confident"] - row["smoothed_frames_wrong_confident"],
        -int(row["causal_depth_reversed"]) - int(row["smoothed_depth_reversed"]),
        row["coverage"],
        -(row["causal_attitude_rms_deg"] or 0.0),
        row["scene"],
        row["setting"],
    )
