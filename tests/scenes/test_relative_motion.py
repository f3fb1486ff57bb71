"""Relative orbits and camera attitudes."""

import numpy as np
from polhode_ground.scenes import pipeline, relative_motion, scene_file, truth
from polhode_ground.scenes.rotations import quat_from_axis_angle, quat_to_matrix

N = 0.0011


def _hill_acceleration(p, v):
    return np.array([3 * N * N * p[0] + 2 * N * v[1], -2 * N * v[0], -N * N * p[2]])


def test_hill_solution_satisfies_its_differential_equation():
    p0, v0 = [10.0, -50.0, 4.0], [0.01, 0.02, -0.005]
    for time_s in (0.0, 700.0, 2500.0):
        h = 0.5
        before, now, after = (relative_motion.hill_state(p0, v0, N, time_s + d) for d in (-h, 0, h))
        assert np.allclose((after[0] - before[0]) / (2 * h), now[1], atol=1e-8)
        assert np.allclose((after[1] - before[1]) / (2 * h), _hill_acceleration(*now), atol=1e-10)


def test_hill_motion_gives_the_inertial_velocity():
    R_IH0 = quat_to_matrix([0.5, 0.5, -0.5, 0.5])

    def at(t):
        return relative_motion.hill_motion([3.0, 1.0, 20.0], [0.001, 0.0, -0.01], R_IH0, N, t)

    assert np.allclose(at(0.0)[0], [3.0, 1.0, 20.0]) and np.allclose(at(0.0)[1], [0.001, 0.0, -0.01])
    assert np.allclose((at(900.5)[0] - at(899.5)[0]), at(900.0)[1], atol=1e-9)


def _motion_table(**changes):
    table = {
        "q_CT0": [1.0, 0.0, 0.0, 0.0],
        "w0_T_deg_s": [0.0, 0.0, 0.0],
        "inertia_kg_m2": np.eye(3).tolist(),
        "p_CT0_m": [0.0, 0.0, 5.0],
        "v_C0_m_s": [0.0, 0.0, -0.1],
        "translation": "constant",
        "q_CH0": [1.0, 0.0, 0.0, 0.0],
        "mean_motion_rad_s": N,
    }
    return {**table, **changes}


def test_a_turning_camera_sees_a_resting_body_turn_the_other_way():
    rate = np.radians(2.0)
    history = relative_motion.turning_history([1, 0, 0, 0], [0.0, rate, 0.0], np.arange(0.0, 11.0))
    motion = truth.motion_at(_motion_table(), history, [0.0, 2.5, 10.0])
    for i, time_s in enumerate((0.0, 2.5, 10.0)):
        R_CI = quat_to_matrix(quat_from_axis_angle([0, 1, 0], rate * time_s)).T
        assert np.allclose(motion.R_CT(i), R_CI, atol=1e-9)
        assert np.allclose(motion.p_CT_m[i], R_CI @ [0.0, 0.0, 5.0 - 0.1 * time_s], atol=1e-9)
        assert np.allclose(motion.v_C_m_s[i], R_CI @ [0.0, 0.0, -0.1], atol=1e-9)


def test_quaternions_come_out_continuous_through_several_turns():
    motion = truth.motion_at(_motion_table(w0_T_deg_s=[0.0, 0.0, 30.0]), [], np.arange(0.0, 60.0))
    assert np.sum(motion.q_CT[1:] * motion.q_CT[:-1], axis=1).min() > 0.9


def test_hill_motion_reaches_the_truth():
    table = _motion_table(translation="hcw", q_CH0=[0.5, 0.5, -0.5, 0.5])
    motion = truth.motion_at(table, [], [0.0, 1.0, 600.0])
    straight = truth.motion_at(_motion_table(), [], [0.0, 1.0, 600.0])
    assert np.allclose(motion.p_CT_m[0], [0, 0, 5]) and np.allclose(motion.v_C_m_s[0], [0, 0, -0.1])
    # Tidal acceleration is at most 3 n^2 r = 1.8e-5 m/s^2 at 5 m: invisible after 1 s, metres after 600 s.
    assert np.abs(motion.p_CT_m[1] - straight.p_CT_m[1]).max() < 2e-5
    assert 0.1 < np.linalg.norm(motion.p_CT_m[2] - straight.p_CT_m[2]) < 20


def test_a_given_attitude_history_is_followed_between_its_rows_whatever_their_norm():
    half = np.sqrt(0.5)
    scene = scene_file.check(
        {
            "target": {"kind": "box"},
            "motion": _motion_table(),
            "camera": {"attitude_history": [[0.0, 3.0, 0.0, 0.0, 0.0], [90.0, 2 * half, 0.0, 0.0, 2 * half]]},
            "time": {"frames": 11, "period_s": 10.0},
        }
    )
    motion = pipeline.Plan(scene).motion
    for i in range(11):
        # One degree a second about the line of sight, held after the last row.
        R_CI = quat_to_matrix(quat_from_axis_angle([0, 0, 1], np.radians(min(10.0 * i, 90.0)))).T
        assert np.allclose(motion.R_CT(i), R_CI, atol=1e-9)
