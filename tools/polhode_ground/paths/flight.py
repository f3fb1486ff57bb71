"""A random flight: how a body turns, is touched, and moves before a camera that turns, too. Nothing keeps it in the view.

Free rotation between contacts is Euler's equation. Half of the flights are what a servicer would fly; the others go to the
edge of what can happen: rates beyond what can be followed, a body that is passed closely or flown through.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Flight:
    """One row a frame. q: w, x, y, z. The servicer knows q_IC where `told`."""

    seconds: np.ndarray  # [N]
    q_CT: np.ndarray  # [N,4]
    p_CT: np.ndarray  # [N,3] m
    v_C: np.ndarray  # [N,3] m/s, of the target as seen from axes that do not turn, in C
    w_T: np.ndarray  # [N,3] rad/s
    q_IC: np.ndarray  # [N,4]
    told: bool
    contacts: tuple[int, ...]  # the frames from which on the rate is another one
    words: str  # what is unusual of it


def _inertia(rng: np.random.Generator) -> np.ndarray:
    """Moments of a cuboid, in its principal axes, which are the body's."""
    a, b, c = rng.uniform(0.2, 1.0, 3) ** 2
    return np.array([b + c, a + c, a + b])


def _turn(q_IT: np.ndarray, w_T: np.ndarray, inertia: np.ndarray, seconds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(q_IT, w_T) at `seconds`, the first of which is now: torque-free."""

    def derivative(_, state):
        q, w = state[:4], state[4:]
        spin = np.array([-q[1:] @ w, *(q[0] * w + np.cross(q[1:], w))])
        return np.concatenate([0.5 * spin, -np.cross(w, inertia * w) / inertia])

    found = solve_ivp(derivative, (seconds[0], seconds[-1]), np.concatenate([q_IT, w_T]), t_eval=seconds, rtol=1e-9, atol=1e-11).y.T
    return found[:, :4] / np.linalg.norm(found[:, :4], axis=1, keepdims=True), found[:, 4:]


def _attitudes(rng, frames: int, period_s: float, turn_rad: float, contacts: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """(q_IT [N,4], w_T [N,3]); at each frame of `contacts` the rate changes by 10 to 300 %."""
    inertia, axis = _inertia(rng), rng.normal(size=3)
    q = rng.normal(size=4)
    q, w = q / np.linalg.norm(q), turn_rad / period_s * axis / np.linalg.norm(axis)
    ends = [0, *contacts, frames]
    q_IT, w_T = [], []
    for first, end in zip(ends, ends[1:]):
        if first > 0:
            blow = rng.normal(size=3)
            w = w + 10 ** rng.uniform(-1, 0.5) * np.linalg.norm(w) * blow / np.linalg.norm(blow)
        turned, rates = _turn(q, w, inertia, period_s * np.arange(end - first + 1))
        q_IT.append(turned[:-1])
        w_T.append(rates[:-1])
        q, w = turned[-1], rates[-1]
    return np.concatenate(q_IT), np.concatenate(w_T)


def _places(rng, seconds: np.ndarray, range_m: float, half_field: float, wild: bool) -> np.ndarray:
    """[N,3] p_IT as the camera would see it without turning: smooth through four places."""
    knots = np.linspace(0, seconds[-1], 4)
    depth_m = range_m * np.exp(rng.uniform(-0.5, 0.5, 4)) * (np.exp(rng.uniform(-1.5, 0.5, 4)) if wild else 1.0)
    if wild and rng.random() < 0.3:
        depth_m[int(rng.integers(1, 4))] *= -0.3
    across = rng.uniform(-1.2 if wild else -0.5, 1.2 if wild else 0.5, (4, 2)) * half_field * np.abs(depth_m)[:, None]
    return PchipInterpolator(knots, np.column_stack([across, depth_m]))(seconds)


def random_flight(rng: np.random.Generator, frames: int, half_field: float) -> Flight:
    """half_field: tangent of half of the smaller angle of view."""
    wild = rng.random() < 0.5
    period_s = float(10 ** rng.uniform(-1.2, 0.7))
    turn_rad = np.radians(10 ** (rng.uniform(-1.0, 1.8) if wild else rng.uniform(-0.2, 0.95)))
    if rng.random() < 0.05:
        turn_rad = 0.0
    contacts = sorted({int(n) for n in rng.integers(2, frames - 1, int(rng.integers(0, 4)))}) if rng.random() < 0.4 else []
    seconds = period_s * np.arange(frames)
    q_IT, w_T = _attitudes(rng, frames, period_s, turn_rad, contacts)
    range_m = 0.6 / half_field / rng.uniform(0.25, 1.1)
    p_I = _places(rng, seconds, range_m, half_field, wild)
    turns, told = rng.random() < 0.3, bool(rng.random() < 0.5)
    rate_C = rng.normal(size=3) * np.array([0.05, 0.05, 0.4]) * turn_rad / period_s if turns else np.zeros(3)
    R_IC = Rotation.from_rotvec(np.outer(seconds, rate_C))
    words = [f"turn {np.degrees(turn_rad):.2f} deg a frame", *(f"contact at {n}" for n in contacts)]
    words += ["wild"] if wild else []
    words += [f"camera turns, {'told' if told else 'not told'}"] if turns else []
    return Flight(
        seconds,
        (R_IC.inv() * Rotation.from_quat(q_IT, scalar_first=True)).as_quat(scalar_first=True),
        R_IC.inv().apply(p_I),
        R_IC.inv().apply(np.gradient(p_I, seconds, axis=0)),
        w_T,
        R_IC.as_quat(scalar_first=True),
        turns and told,
        tuple(contacts),
        ", ".join(words),
    )
