"""The judge on made-up trajectories: what goes in as an error comes out as that number, and nothing else does."""

import csv
import json
import pathlib
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from polhode_ground.common.sequence import read_sequence
from polhode_ground.judge import metrics, period, twin
from polhode_ground.judge.report import text_report
from polhode_ground.judge.run import judge_run, read_run, read_truth
from polhode_ground.testing.synthetic import Errors, box_points, project, tumbling_body, write_run, write_sequence
from scipy.spatial.transform import Rotation

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def body():
    return tumbling_body()


@pytest.fixture(scope="module")
def scene(tmp_path_factory, body):
    return write_sequence(tmp_path_factory.mktemp("scene") / "seq", body)


def judged(tmp_path, scene, body, causal, cloud=False):
    sequence = read_sequence(scene)
    run = read_run(write_run(tmp_path / "run", body, causal))
    if not cloud:  # sampling the mesh takes the most time, and only the tests of shape look at it
        (run.folder / "cloud.ply").unlink()
    return judge_run(run, sequence, read_truth(sequence))


# verifies: GND-02
def test_truth_is_consistent_with_itself(body):
    """The made-up body's rates are the derivative of its attitude, or every test below would test nothing."""
    step = (body.R_CT[:-1].inv() * body.R_CT[1:]).as_rotvec()
    middle = 0.5 * (body.w_T[1:] + body.w_T[:-1])
    assert np.abs(step - middle).max() < 2e-5


def test_perfect_run_in_another_body_frame_has_no_error(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors())["motion"]["causal"]
    assert report["attitude"]["max_deg"] < 1e-5
    assert report["position"]["rmse_percent_of_range"] < 1e-4
    assert report["position"]["rmse_from_camera_percent_of_range"] < 1e-4
    assert report["position"]["rmse_m"] < 1e-5
    assert report["rates"]["rmse_norm_deg_s"] < 1e-8
    assert report["velocity"]["rmse_offset_corrected_m_s"] < 1e-6
    assert report["coverage"]["coverage"] == 1.0
    assert report["twin"]["verdict"] == "truth"


# verifies: GND-02
def test_one_degree_in_is_one_degree_out(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(attitude_rms_rad=np.radians(1.0)))["motion"]["causal"]
    # 120 random axes: the alignment absorbs about 3 of 360 degrees of freedom, 0.4 % of the RMSE.
    assert report["attitude"]["rmse_deg"] == pytest.approx(1.0, rel=0.02)
    assert report["attitude"]["max_deg"] == pytest.approx(1.0, rel=0.25)


def test_constant_rotation_and_offset_are_no_error_whatever_their_size(tmp_path, scene, body):
    errors = Errors(R_ET=Rotation.from_rotvec([0, 3.1, 0.1]), offset_E_m=(0.5, -0.3, 0.2))
    report = judged(tmp_path, scene, body, errors)["motion"]["causal"]
    assert report["attitude"]["rmse_deg"] < 1e-5
    assert report["position"]["rmse_percent_of_range"] < 1e-4
    # The origin's own velocity is real, though: as published it is not that of the centre of mass.
    assert report["velocity"]["rmse_m_s"] > 0.005
    assert report["velocity"]["rmse_offset_corrected_m_s"] < 1e-6


def test_position_error_in_is_position_error_out(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(position_rms_m=0.08))["motion"]["causal"]
    assert report["position"]["rmse_percent_of_range"] == pytest.approx(100 * 0.08 / 7.45, rel=0.06)
    assert report["position"]["rmse_from_camera_percent_of_range"] == pytest.approx(100 * 0.08 / 7.45, rel=0.06)
    assert report["position"]["rmse_m"] == pytest.approx(0.08, rel=0.06)


def test_wrong_scale_shows_in_metres_and_not_in_percent_of_range(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(scale=1.05))["motion"]["causal"]
    assert report["position"]["rmse_percent_of_range"] < 1e-4
    assert report["position"]["scale_error_percent"] == pytest.approx(5.0, abs=1e-3)
    assert report["position"]["rmse_m"] == pytest.approx(0.05 * 7.4, rel=0.1)
    assert report["velocity"]["mean_error_offset_corrected_percent"] == pytest.approx(5.0, abs=1e-3)


def test_map_units_take_the_scale_from_the_alignment_and_say_so(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(scale=0.13, scale_known=False))["motion"]["causal"]
    assert report["position"]["rmse_m"] is None and report["position"]["scale_error_percent"] is None
    assert report["velocity"]["scale_from_alignment"] is True
    assert report["velocity"]["rmse_offset_corrected_m_s"] < 1e-6


def test_a_scale_that_becomes_known_on_the_way_is_judged_from_there_on(tmp_path, scene, body):
    run = read_run(write_run(tmp_path / "run", body, Errors(velocity_rms_m_s=0.001)))
    motion = run.motions["causal"]
    motion.scale_known[:40] = False
    motion.p_CT[:40] *= 3.0
    motion.v_C[:40] *= 3.0
    report = judge_run(run, read_sequence(scene), read_truth(read_sequence(scene)))["motion"]["causal"]
    assert report["position"]["metric"] and report["position"]["rmse_m"] < 1e-5
    assert abs(report["position"]["scale_error_percent"]) < 1e-3 and report["position"]["rmse_percent_of_range"] < 1e-4
    assert report["velocity"]["frames"] == 80 and report["attitude"]["max_deg"] < 1e-5
    assert report["velocity"]["rmse_offset_corrected_m_s"] == pytest.approx(0.001, rel=0.2)


def test_rate_and_velocity_errors_come_out(tmp_path, scene, body):
    errors = Errors(rate_rms_rad_s=np.radians(0.3), velocity_rms_m_s=0.002)
    report = judged(tmp_path, scene, body, errors)["motion"]["causal"]
    assert report["rates"]["rmse_norm_deg_s"] == pytest.approx(0.3, rel=1e-3)
    for axis in "xyz":
        assert report["rates"]["rmse_deg_s"][axis] == pytest.approx(0.3 / np.sqrt(3), rel=0.2)
    assert report["velocity"]["rmse_offset_corrected_m_s"] == pytest.approx(0.002, rel=1e-3)


def test_honest_sigmas_pass_and_small_ones_fail(tmp_path, scene, body):
    errors = Errors(attitude_rms_rad=0.01, position_rms_m=0.05, rate_rms_rad_s=0.001, velocity_rms_m_s=0.002)
    report = judged(tmp_path, scene, body, errors)["motion"]["causal"]
    for name in ("attitude", "position", "rate", "velocity"):
        assert report["consistency"][name]["within_95_percent_bound"] == 1.0, name
        assert report["consistency"][name]["rms_normalised"] == pytest.approx(1.0, rel=0.05), name
    assert metrics._normalised(np.full(50, 3.0), np.full(50, 1.0))["within_95_percent_bound"] == 0.0


def test_sigmas_in_metres_must_hold_the_error_of_the_scale(tmp_path, scene, body):
    """A run without a scale gets it from the alignment; one in metres answers for its own."""
    errors = Errors(scale=1.05, position_rms_m=0.005)
    claimed, unknown = (judged(tmp_path / name, scene, body, errors if known else replace(errors, scale_known=False))
                        for name, known in (("claimed", True), ("unknown", False)))
    position = [report["motion"]["causal"]["consistency"]["position"] for report in (claimed, unknown)]
    assert position[0]["within_95_percent_bound"] == 0.0
    assert position[1]["within_95_percent_bound"] > 0.9


def test_normal_errors_lie_within_the_bound_in_95_of_100_frames():
    error = np.linalg.norm(np.random.default_rng(5).normal(size=(20000, 3)), axis=1)
    assert metrics._normalised(error, np.ones(20000))["within_95_percent_bound"] == pytest.approx(0.95, abs=0.006)


def test_a_sigma_of_zero_is_a_promise_that_counts():
    judged = metrics._normalised(np.full(10, 0.5), np.array([1.0] + 9 * [0.0]))
    assert judged["frames"] == 10
    assert judged["within_95_percent_bound"] == pytest.approx(0.1)
    assert judged["median_normalised"] == pytest.approx(0.5)
    assert metrics._normalised(np.ones(3), np.zeros(3))["rms_normalised"] is None


def test_twin_is_named(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(twin=True, attitude_rms_rad=0.01))["motion"]["causal"]
    # The body is about 2 deg off the boresight, and the made-up twin is mirrored along the boresight itself: 4 deg apart.
    assert report["twin"]["verdict"] == "twin"
    assert report["twin"]["rmse_to_twin_deg"] < 6.0 < report["twin"]["rmse_to_truth_deg"]
    assert report["twin"]["in_plane_rate_factor"] == pytest.approx(-1.0, abs=0.05)


def test_twin_gives_the_same_picture_from_far_away(body):
    """What makes it the twin: the body mirrored in depth, at the twin's attitudes, is seen at the same pixels."""
    p_CT = body.p_CT + [20.0, -10.0, 392.0]
    points_T = box_points(50)
    mirrored_T = points_T @ np.diag([1.0, 1.0, -1.0])
    turned = twin.twin_of(body.R_CT, p_CT)
    for i in range(0, len(p_CT), 10):
        true_px = project(body.R_CT[i].apply(points_T) + p_CT[i])
        twin_px = project(turned[i].apply(mirrored_T) + p_CT[i])
        # The perspective within the body is what is left: 1.3 px across it, times 0.6 m / 400 m.
        assert np.abs(true_px - twin_px).max() < 0.005


def test_nonsense_is_neither_truth_nor_twin(body):
    random = Rotation.random(len(body.time_s), rng=np.random.default_rng(4))
    assert twin.judge_twin(random, body.R_CT, body.p_CT)["verdict"] == "neither"


def test_a_map_that_fell_in_two_is_neither_though_nearer_to_the_truth(body):
    """A spin about an axis in the image plane is a half-turn from its twin: 40 deg are then near, but not right."""
    spin = Rotation.from_rotvec(np.outer(0.05 * body.time_s, [0, 1, 0]))
    ahead = np.tile([0.0, 0.0, 8.0], (len(body.time_s), 1))
    slipped = Rotation.concatenate([spin[:60], Rotation.from_rotvec([1.4, 0, 0]) * spin[60:]])
    found = twin.judge_twin(slipped, spin, ahead)
    assert found["rmse_to_truth_deg"] < found["rmse_to_twin_deg"]
    assert found["verdict"] == "neither"


def test_twin_is_indistinguishable_when_the_body_turns_about_the_line_of_sight(body):
    spin = Rotation.from_rotvec(np.outer(0.03 * body.time_s, [0, 0, 1]))
    ahead = np.tile([0.0, 0.0, 8.0], (len(body.time_s), 1))
    assert twin.judge_twin(spin, spin, ahead)["verdict"] == "indistinguishable"


def test_a_few_lost_frames_do_not_bend_the_alignment(tmp_path, scene, body):
    """A third of the poses are wild: the others must still be judged right."""
    run = write_run(tmp_path / "run", body, Errors())
    rows = list(csv.reader((run / "motion.csv").open()))
    for row in rows[1::3]:
        row[7:11] = ["0.5", "-0.5", "0.5", "0.5"]
    (run / "motion.csv").write_text("\n".join(",".join(row) for row in rows) + "\n")
    sequence = read_sequence(scene)
    report = judge_run(read_run(run), sequence, read_truth(sequence))["motion"]["causal"]
    assert report["attitude"]["median_deg"] < 1e-4
    assert report["attitude"]["rmse_deg"] > 20


def test_late_start_counts(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(first_frame=12))["motion"]["causal"]["coverage"]
    assert report["frames_until_first_pose"] == 12
    assert report["coverage"] == pytest.approx(0.9)
    assert report["coverage_after_first_pose"] == 1.0


def test_counts_over_time_are_means_of_tenths_of_the_run(tmp_path, scene, body):
    parts = judged(tmp_path, scene, body, Errors(first_frame=12))["motion"]["causal"]["counts"]
    # The made-up run has 120 frames of 1 s; it tells 400 + i landmarks from frame 12 on, and none before.
    assert [round(part["from_s"]) for part in parts] == [12 * i for i in range(10)] and round(parts[-1]["to_s"]) == 119
    assert parts[0]["landmarks"] == 0 and parts[3]["landmarks"] == pytest.approx(400 + 36 + 5.5)
    assert all(part["features"] > part["inliers"] for part in parts)


def test_straight_approach_without_rotation_is_well_conditioned(tmp_path):
    still = tumbling_body(turning=False, velocity_m_s=(0.0, 0.0, -0.03))
    scene = write_sequence(tmp_path / "seq", still)
    report = judged(tmp_path, scene, still, Errors(scale=0.2, scale_known=False, position_rms_m=0.01))
    position = report["motion"]["causal"]["position"]
    assert position["rmse_percent_of_range"] == pytest.approx(100 * 0.01 / 6.2, rel=0.15)
    assert position["rmse_from_camera_percent_of_range"] == pytest.approx(100 * 0.01 / 6.2, rel=0.15)
    assert report["motion"]["causal"]["alignment"]["scale"] == pytest.approx(5.0, rel=0.02)
    assert report["motion"]["causal"]["twin"]["verdict"] == "indistinguishable"


def test_truth_without_rates_is_judged_by_poses(tmp_path, body):
    scene = write_sequence(tmp_path / "seq", body, rates=False)
    report = judged(tmp_path, scene, body, Errors())["motion"]["causal"]
    assert report["rates"] is None and report["velocity"] is None
    assert report["attitude"]["rmse_deg"] < 1e-5


def test_never_acquired_is_a_report_and_no_crash(tmp_path, scene, body):
    report = judged(tmp_path, scene, body, Errors(first_frame=10_000), cloud=True)
    assert report["motion"]["causal"]["coverage"]["coverage"] == 0
    assert report["motion"]["causal"]["coverage"]["frames_until_first_pose"] is None
    assert "attitude" not in report["motion"]["causal"]
    assert report["shape"] is None


def test_cloud_on_the_surface_has_no_distance_and_covers_what_was_seen(tmp_path, scene, body):
    shape = judged(tmp_path, scene, body, Errors(), cloud=True)["shape"]
    assert shape["body_size_m"] == pytest.approx(np.linalg.norm([0.6, 0.4, 1.0]), rel=1e-5)
    assert shape["distance_rmse_percent"] < 0.3  # the spacing of the samples
    assert shape["complete_seen_within_5_percent"] > 0.9
    assert 0.3 < shape["seen_share_of_surface"] <= 1.0


def test_cost_is_per_frame_in_milliseconds_and_megabytes(tmp_path, scene, body):
    cost = judged(tmp_path, scene, body, Errors())["cost"]
    assert cost["cpu_per_frame_ms"] == pytest.approx(10.0)
    assert cost["cpu_total_per_frame_ms"] == pytest.approx(10.0 + 500 / 120)
    assert cost["wall_per_frame_ms"] == pytest.approx(20.0)
    assert cost["peak_resident_mb"] == pytest.approx(50.0)
    assert cost["step_p50_ms"] == pytest.approx(9.0) and cost["step_max_ms"] == pytest.approx(12.0)
    assert cost["step_p95_ms"] == pytest.approx(13.5, rel=0.1)  # not in the summary: from the rows themselves


def test_period_of_a_noisy_sine_is_found():
    time_s = np.arange(0, 3000, 10.0)
    random = np.random.default_rng(2)
    truth = 0.1 * np.sin(2 * np.pi * time_s / 376.0)
    noisy = 0.1 * np.sin(2 * np.pi * time_s / 376.0 + 0.1) + random.normal(0, 0.01, len(time_s))
    found = period.period_error(time_s, noisy, truth, 1.0)
    assert found["period_true_s"] == pytest.approx(376.0, rel=1e-6)
    assert found["error_percent"] < 0.2
    stretched = 0.1 * np.sin(2 * np.pi * time_s / (376.0 * 1.01))
    assert period.period_error(time_s, stretched, truth, 1.0)["error_percent"] == pytest.approx(1.0, rel=1e-3)
    assert period.period_error(time_s, noisy, np.full(len(time_s), 0.2), 1.0) is None


def test_periods_are_reported_for_the_turning_components_only(tmp_path, body):
    long = tumbling_body(frames=400)
    scene = write_sequence(tmp_path / "seq", long)
    periods = judged(tmp_path, scene, long, Errors())["motion"]["causal"]["rates"]["period"]
    assert periods["x"]["period_true_s"] == pytest.approx(300.0, rel=1e-4)  # 360 deg / (0.6 * 2 deg/s)
    assert periods["x"]["error_percent"] < 1e-4 and periods["y"]["error_percent"] < 1e-4
    assert periods["z"] is None


def evaluate(*arguments):
    return subprocess.run([sys.executable, REPOSITORY / "hil/evaluate.py", *map(str, arguments)],
                          capture_output=True, text=True)


def test_script_compares_runs_writes_json_and_plots(tmp_path, scene, body):
    good = write_run(tmp_path / "good", body, Errors(attitude_rms_rad=0.01), Errors(), scene)
    twin_run = write_run(tmp_path / "mirrored", body, Errors(twin=True), sequence=scene)
    done = evaluate(good, scene, "--vs", twin_run, "--json", tmp_path / "out/report.json", "--plots", tmp_path / "plots")
    assert done.returncode == 0, done.stderr
    assert "good smoothed" in done.stdout and "DEPTH-REVERSED TWIN" in done.stdout and "the same bytes" in done.stdout
    reports = json.loads((tmp_path / "out/report.json").read_text())["runs"]
    assert [report["motion"]["smoothed"]["twin"]["verdict"] for report in reports] == ["truth", "twin"]
    assert len(list((tmp_path / "plots").glob("*.png"))) >= 4


@pytest.mark.parametrize("damage, expected", [
    (lambda run, seq: (run / "motion.csv").write_text(""), "motion.csv: empty"),
    (lambda run, seq: (run / "motion.csv").write_text("frame,timestamp_ns\n0,1\n"), "column q_CT_w is missing"),
    (lambda run, seq: (run / "motion.csv").write_text(
        (run / "motion.csv").read_text().replace("TRACKING,1,1,1,1,", "TRACKING,1,1,1,1,7", 1)), "norm"),
    (lambda run, seq: (run / "summary.json").write_text("{"), "summary.json"),
    (lambda run, seq: (run / "cloud.ply").write_text("no ply"), "cloud.ply"),
    (lambda run, seq: (seq / "truth.csv").unlink(), "truth.csv"),
    (lambda run, seq: (seq / "mav0/cam0/sensor.yaml").write_text("camera_model: pinhole\ndistortion_model: radial-tangential\nresolution: [1, two]\n"), "resolution"),
    (lambda run, seq: (seq / "mav0/cam0/data.csv").unlink(), "data.csv"),
], ids=["empty", "columns", "norm", "json", "ply", "truth", "yaml", "data"])
def test_bad_input_gets_one_line_and_status_2(tmp_path, damage, expected):
    small = tumbling_body(frames=12)
    seq = write_sequence(tmp_path / "seq", small)
    run = write_run(tmp_path / "run", small, Errors())
    damage(run, seq)
    done = evaluate(run, seq)
    assert done.returncode == 2
    assert expected in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_another_sequences_truth_is_refused(tmp_path, scene):
    small = tumbling_body(frames=12)
    other = write_run(tmp_path / "run", small, Errors())
    text = (other / "motion.csv").read_text().replace("17000000", "16000000")
    (other / "motion.csv").write_text(text)
    done = evaluate(other, scene)
    assert done.returncode == 2 and "another sequence" in done.stderr


def two_frames(first: pathlib.Path, second: pathlib.Path, at: int) -> None:
    """Rows of `first` from `at` on become those of `second`, in target frame 2."""
    with open(first, newline="") as a, open(second, newline="") as b:
        header, *rows = csv.reader(a)
        later = list(csv.reader(b))[1:]
    with open(first, "w", newline="") as stream:
        csv.writer(stream).writerows([header, *rows[:at], *([*row[:-1], "2"] for row in later[at:])])


def test_each_target_frame_is_aligned_by_itself(tmp_path, scene, body):
    """A map begun anew has other axes, another unit and another origin: none of that is an error of the estimate."""
    sequence = read_sequence(scene)
    truth = read_truth(sequence)
    first = write_run(tmp_path / "run", body, Errors(attitude_rms_rad=np.radians(0.2)))
    second = write_run(tmp_path / "other", body, Errors(attitude_rms_rad=np.radians(0.2), scale=2.5, scale_known=False,
                                                        R_ET=Rotation.from_rotvec([2.0, 0.3, -0.4]), offset_E_m=(0.4, 0.1, -0.2)))
    (first / "cloud.ply").unlink()
    two_frames(first / "motion.csv", second / "motion.csv", at=70)
    report = judge_run(read_run(first), sequence, truth)
    causal = report["motion"]["causal"]
    assert causal["target_frames"]["count"] == 2 and causal["target_frames"]["poses_not_judged"] == 0
    assert [one["frames"] for one in causal["target_frames"]["each"]] == [70, 50]
    assert causal["attitude"]["rmse_deg"] == pytest.approx(0.2, rel=0.05)
    # Attitude noise leaves the alignment 0.2 deg / sqrt(50) = 0.03 deg off, which turns 2.3 deg/s by 0.0012 deg/s.
    assert causal["rates"]["rmse_norm_deg_s"] < 2.5 * 0.0012
    # The origin is 0.5 m off: 0.2 deg of it are 0.02 % of the range of 8 m.
    assert causal["position"]["rmse_from_camera_percent_of_range"] < 2.5 * 0.02
    assert causal["twin"]["verdict"] == "truth"
    assert "poses are in 2 target frames T" in text_report([report])


def test_a_wrong_target_frame_is_not_hidden_by_a_right_one(tmp_path, scene, body):
    first = write_run(tmp_path / "run", body, Errors())
    twin_run = write_run(tmp_path / "other", body, Errors(twin=True))
    two_frames(first / "motion.csv", twin_run / "motion.csv", at=70)
    (first / "cloud.ply").unlink()
    sequence = read_sequence(scene)
    causal = judge_run(read_run(first), sequence, read_truth(sequence))["motion"]["causal"]
    assert [one["twin"]["verdict"] for one in causal["target_frames"]["each"]] == ["truth", "twin"]
    assert causal["twin"]["verdict"] == "twin"


def test_the_only_pose_of_a_target_frame_is_counted_as_not_judged(tmp_path, scene, body):
    first = write_run(tmp_path / "run", body, Errors())
    second = write_run(tmp_path / "other", body, Errors(R_ET=Rotation.from_rotvec([2.0, 0.3, -0.4])))
    two_frames(first / "motion.csv", second / "motion.csv", at=119)
    (first / "cloud.ply").unlink()
    sequence = read_sequence(scene)
    causal = judge_run(read_run(first), sequence, read_truth(sequence))["motion"]["causal"]
    assert causal["target_frames"]["count"] == 2 and causal["target_frames"]["poses_not_judged"] == 1
    assert causal["attitude"]["max_deg"] < 1e-5
