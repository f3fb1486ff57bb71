"""Periods of angular velocity components by a least-squares sine fit, as the paper reports them."""

from typing import Any

import numpy as np
from scipy.optimize import least_squares

# A component whose true amplitude is below this part of the total rate has no period worth a name.
AMPLITUDE_RELATIVE_MIN = 0.01
# Less of a cycle than this leaves the period to the noise.
CYCLES_MIN = 0.75
SAMPLES_MIN = 8


def _linear_fit(time_s: np.ndarray, value: np.ndarray, frequency_hz: np.ndarray) -> np.ndarray:
    """Residual sum of squares [F] of offset + sine + cosine at each trial frequency."""
    cost = np.empty(len(frequency_hz))
    for index, frequency in enumerate(frequency_hz):
        phase = 2 * np.pi * frequency * time_s
        basis = np.column_stack([np.ones_like(time_s), np.cos(phase), np.sin(phase)])
        solution = np.linalg.lstsq(basis, value, rcond=None)[0]
        cost[index] = ((basis @ solution - value) ** 2).sum()
    return cost


def fit_sine(time_s: np.ndarray, value: np.ndarray) -> dict[str, Any] | None:
    """Offset, amplitude, period [s] and phase of the best sine; None where there is none to fit.

    A grid over frequency (fine enough that the optimum's basin is not missed), then nonlinear least squares.
    """
    if len(time_s) < SAMPLES_MIN:
        return None
    time_s = time_s - time_s[0]
    span_s = time_s[-1]
    nyquist_hz = 0.5 / np.median(np.diff(time_s))
    # A gap of days between frames makes the grid of its span endless; and cycles across it cannot be counted.
    if not 0.4 / span_s < nyquist_hz or nyquist_hz * span_s > 5 * len(time_s):
        return None
    grid_hz = np.arange(0.4 / span_s, nyquist_hz, 0.1 / span_s)
    frequency = grid_hz[int(np.argmin(_linear_fit(time_s, value, grid_hz)))]
    phase = 2 * np.pi * frequency * time_s
    basis = np.column_stack([np.ones_like(time_s), np.cos(phase), np.sin(phase)])
    offset, cosine, sine = np.linalg.lstsq(basis, value, rcond=None)[0]
    scale = max(np.std(value), 1e-12)

    def residual(x: np.ndarray) -> np.ndarray:
        angle = 2 * np.pi * x[3] / span_s * time_s
        return np.asarray((x[0] + x[1] * np.cos(angle) + x[2] * np.sin(angle) - value) / scale)

    fit = least_squares(residual, [offset, cosine, sine, frequency * span_s], x_scale=[scale, scale, scale, 0.1])
    offset, cosine, sine, cycles = fit.x
    if cycles <= 0:
        return None
    return {
        "offset": float(offset),
        "amplitude": float(np.hypot(cosine, sine)),
        "cycles": float(cycles),
        "period_s": float(span_s / cycles),
        "cosine": float(cosine),
        "sine": float(sine),
    }


def sine_curve(fit: dict[str, Any], time_s: np.ndarray, start_s: float) -> np.ndarray:
    """Values of a fit made on samples that began at start_s."""
    angle = 2 * np.pi / fit["period_s"] * (time_s - start_s)
    return np.asarray(fit["offset"] + fit["cosine"] * np.cos(angle) + fit["sine"] * np.sin(angle))


def period_error(time_s: np.ndarray, estimate: np.ndarray, truth: np.ndarray, rate_total: float) -> dict[str, Any] | None:
    """Period of the truth, of the estimate and their relative error [%]; None where the truth is constant."""
    fit_true = fit_sine(time_s, truth)
    if fit_true is None or fit_true["amplitude"] < AMPLITUDE_RELATIVE_MIN * rate_total:
        return None
    if fit_true["cycles"] < CYCLES_MIN:
        return None
    fit_estimate = fit_sine(time_s, estimate)
    if fit_estimate is None:
        return None
    period_true_s, period_s = fit_true["period_s"], fit_estimate["period_s"]
    return {
        "period_true_s": period_true_s,
        "period_s": period_s,
        "cycles": fit_true["cycles"],
        "error_percent": 100 * abs(period_s - period_true_s) / period_true_s,
    }
