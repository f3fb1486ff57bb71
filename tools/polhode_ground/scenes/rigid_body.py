"""Torque-free rotation of a rigid body: Euler's equation, fourth-order Runge-Kutta.

Frames: I inertial, T body-fixed with its origin at the centre of mass.
State: q_IT (w, x, y, z) and w_T_rad_s, the angular velocity of T relative to I in T components.
"""

import numpy as np

from .rotations import quat_to_matrix

# 1e-9 rad at 1000 px of focal length and any range is 1e-6 px: far below what a pixel can show.
ATTITUDE_TOLERANCE_RAD = 1e-9
ANGLE_PER_STEP_RAD = 0.02
HALVINGS_MAX = 8
# Some minutes; a scene that needs more is a mistake in its rates or times.
STEPS_MAX = 2_000_000


class NotIntegrated(Exception):
    """The motion needs too many steps, or did not converge within HALVINGS_MAX halvings of the step."""


def _derivative(state, inertia, inertia_inverse):
    """Time derivative of [q_IT, w_T_rad_s], shape (7,): N = I dw/dt + w x I w with N = 0."""
    qw, qx, qy, qz, wx, wy, wz = state
    w_T = state[4:]
    h_T = inertia @ w_T
    torque_T = np.array([-(wy * h_T[2] - wz * h_T[1]), -(wz * h_T[0] - wx * h_T[2]), -(wx * h_T[1] - wy * h_T[0])])
    out = np.empty(7)
    out[0] = 0.5 * (-qx * wx - qy * wy - qz * wz)
    out[1] = 0.5 * (qw * wx + qy * wz - qz * wy)
    out[2] = 0.5 * (qw * wy - qx * wz + qz * wx)
    out[3] = 0.5 * (qw * wz + qx * wy - qy * wx)
    out[4:] = inertia_inverse @ torque_T
    return out


def _step(state, dt_s, inertia, inertia_inverse):
    k1 = _derivative(state, inertia, inertia_inverse)
    k2 = _derivative(state + 0.5 * dt_s * k1, inertia, inertia_inverse)
    k3 = _derivative(state + 0.5 * dt_s * k2, inertia, inertia_inverse)
    k4 = _derivative(state + dt_s * k3, inertia, inertia_inverse)
    state = state + dt_s / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    state[:4] /= np.linalg.norm(state[:4])
    return state


def _integrate_at_step(state, times_s, step_s, inertia):
    """States (N, 7) at the given ascending times, none before 0, with steps of at most step_s."""
    inertia_inverse = np.linalg.inv(inertia)
    states = np.empty((len(times_s), 7))
    now_s = 0.0
    for i, time_s in enumerate(times_s):
        interval_s = time_s - now_s
        if interval_s > 0:
            count = int(np.ceil(interval_s / step_s))
            for _ in range(count):
                state = _step(state, interval_s / count, inertia, inertia_inverse)
        states[i] = state
        now_s = time_s
    return states


def integrate(q_IT0, w0_T_rad_s, inertia_kg_m2, times_s):
    """Attitude and rate at times_s (ascending, >= 0; the given state holds at time 0).

    Halves the step until attitudes at half the step agree within ATTITUDE_TOLERANCE_RAD; NotIntegrated if they never do.
    Returns q_IT (N, 4), w_T_rad_s (N, 3), step_s (the accepted step).
    """
    inertia = np.asarray(inertia_kg_m2, dtype=float)
    state = np.concatenate([q_IT0, w0_T_rad_s]).astype(float)
    state[:4] /= np.linalg.norm(state[:4])
    # The fastest rate in the motion is bounded by the largest momentum over the smallest inertia.
    momentum = np.linalg.norm(inertia @ state[4:])
    rate_max = max(momentum / np.linalg.eigvalsh(inertia)[0], 1e-12)
    rate_max = min(rate_max, 20 * max(np.linalg.norm(state[4:]), 1e-12))
    step_s = ANGLE_PER_STEP_RAD / rate_max
    if times_s[-1] / step_s > STEPS_MAX:
        raise NotIntegrated(f"{times_s[-1]:.4g} s at up to {np.degrees(rate_max):.4g} deg/s are too many turns to compute")
    coarse = _integrate_at_step(state, times_s, step_s, inertia)
    for _ in range(HALVINGS_MAX):
        step_s *= 0.5
        fine = _integrate_at_step(state, times_s, step_s, inertia)
        cosines = np.abs(np.sum(coarse[:, :4] * fine[:, :4], axis=1))
        # 2 * |q - q'| is the angle for small angles; arccos would lose half of the digits.
        signs = np.sign(np.sum(coarse[:, :4] * fine[:, :4], axis=1))[:, None]
        angle_rad = 2 * np.linalg.norm(coarse[:, :4] * signs - fine[:, :4], axis=1).max()
        if cosines.min() > 0.5 and angle_rad < ATTITUDE_TOLERANCE_RAD:
            return fine[:, :4], fine[:, 4:], step_s
        coarse = fine
    raise NotIntegrated(f"attitude still changes by {angle_rad:.1e} rad at a step of {step_s:.1e} s")


def momentum_I(q_IT, w_T_rad_s, inertia_kg_m2):
    """Angular momentum in I, kg m^2/s, shape (3,). Constant in torque-free motion."""
    return quat_to_matrix(q_IT) @ (np.asarray(inertia_kg_m2) @ w_T_rad_s)
