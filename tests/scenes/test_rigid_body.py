"""The integrator against what mechanics says must hold."""

import numpy as np
import pytest
from polhode_ground.scenes import rigid_body
from polhode_ground.scenes.rotations import quat_from_axis_angle, quat_multiply, quat_to_matrix


# verifies: GND-05
def test_momentum_and_energy_stay_constant_for_a_full_tensor():
    inertia = np.array([[0.42, 0.02, -0.01], [0.02, 0.30, 0.015], [-0.01, 0.015, 0.24]])
    times_s = np.linspace(0, 300, 61)
    q, w, _ = rigid_body.integrate([1, 0, 0, 0], np.radians([2.6, 3.4, 2.6]), inertia, times_s)
    momenta = np.array([rigid_body.momentum_I(a, b, inertia) for a, b in zip(q, w)])
    energies = np.array([b @ inertia @ b for b in w])
    # 26 rad of turn at an attitude error below 1e-9 rad: relative momentum errors are of that order.
    assert np.abs(momenta - momenta[0]).max() < 1e-8 * np.linalg.norm(momenta[0])
    assert np.abs(energies / energies[0] - 1).max() < 1e-8


# verifies: GND-05
def test_an_axisymmetric_body_follows_the_closed_solution():
    inertia = np.diag([0.47, 0.47, 0.02])
    w0 = np.radians([0.0, 0.1, 1.0])
    times_s = np.arange(0, 3000, 250.0)
    q, w, _ = rigid_body.integrate([1, 0, 0, 0], w0, inertia, times_s)
    # Body rate: w_xy turns about z by (I_z - I_t)/I_t * w_z. Attitude: R(H, |H|/I_t * t) * R(z, -body rate * t).
    body_rate = (0.02 - 0.47) / 0.47 * w0[2]
    h_I = inertia @ w0
    for time_s, q_IT, w_T in zip(times_s, q, w):
        angle = body_rate * time_s
        expected = [w0[1] * -np.sin(angle), w0[1] * np.cos(angle), w0[2]]
        assert np.allclose(w_T, expected, atol=1e-10)
        precession = quat_from_axis_angle(h_I, np.linalg.norm(h_I) / 0.47 * time_s)
        turn = quat_from_axis_angle([0, 0, 1], -body_rate * time_s)
        assert abs(abs(np.dot(quat_multiply(precession, turn), q_IT)) - 1) < 1e-12


def test_a_body_at_rest_stays_at_rest():
    q, w, _ = rigid_body.integrate([0.5, 0.5, 0.5, -0.5], [0, 0, 0], np.eye(3), [0.0, 1e4])
    assert np.allclose(q[1], [0.5, 0.5, 0.5, -0.5]) and np.all(w == 0)


def test_attitude_derivative_agrees_with_the_rate():
    inertia = np.diag([1.0, 2.0, 2.5])
    times_s = np.array([10.0, 10.001])
    q, w, _ = rigid_body.integrate([1, 0, 0, 0], [0.05, 0.08, -0.02], inertia, times_s)
    turn = quat_to_matrix(q[0]).T @ quat_to_matrix(q[1])
    rate = np.array([turn[2, 1], turn[0, 2], turn[1, 0]]) / 0.001
    assert np.allclose(rate, w.mean(axis=0), atol=1e-5)


def test_halving_the_step_is_what_decides_and_too_many_turns_are_refused(monkeypatch):
    inertia, w0, times_s = np.diag([1.0, 2.0, 2.5]), [0.05, 0.08, -0.02], [200.0]
    q, _, step_s = rigid_body.integrate([1, 0, 0, 0], w0, inertia, times_s)
    finer = rigid_body._integrate_at_step(np.array([1, 0, 0, 0, *w0]), times_s, step_s / 2, inertia)[:, :4]
    assert 2 * np.linalg.norm(q - finer) < rigid_body.ATTITUDE_TOLERANCE_RAD
    with pytest.raises(rigid_body.NotIntegrated, match="too many turns"):
        rigid_body.integrate([1, 0, 0, 0], [0.0, 0.0, 1e6], inertia, times_s)
    monkeypatch.setattr(rigid_body, "HALVINGS_MAX", 1)
    monkeypatch.setattr(rigid_body, "ATTITUDE_TOLERANCE_RAD", 0.0)
    with pytest.raises(rigid_body.NotIntegrated, match="still changes"):
        rigid_body.integrate([1, 0, 0, 0], w0, inertia, times_s)
