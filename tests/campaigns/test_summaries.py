"""Figures of a table against those computed by hand, and what never was counted as never."""

import numpy as np
import pytest
from polhode_ground.campaigns import summaries
from polhode_ground.campaigns.summaries import NEVER, Measure

SHARE = Measure("acquired", "acquired", "share", 1, 100)
COVERAGE = Measure("coverage", "coverage", "mean", 1, 100, never=0.0)
TURN = Measure("first pose", "first_pose_turn_deg", "median", -1, never=NEVER)
ERROR = Measure("error", "error", "median")


def runs(**columns):
    count = len(next(iter(columns.values())))
    return [{"scene": f"s{i}", "transform": "plain", "setting": "default", "sequence_key": f"s{i}", **{name: values[i] for name, values in columns.items()}}
            for i in range(count)]


def test_a_run_that_never_acquires_counts():
    found = summaries.summary(runs(first_pose_turn_deg=[5.0, 7.0, None, None, None]), TURN)
    assert found["centre"] == NEVER and found["worst"] == NEVER and found["count"] == 5
    found = summaries.summary(runs(coverage=[1.0, 0.5, None]), COVERAGE)
    assert found["centre"] == pytest.approx(50.0) and found["worst"] == 0.0


def test_a_run_without_a_value_is_left_out_and_said_so():
    found = summaries.summary(runs(error=[1.0, None, 3.0, 2.0]), ERROR)
    assert (found["count"], found["of"], found["centre"], found["worst"]) == (3, 4, 2.0, 3.0)
    assert summaries.summary(runs(error=[None, None]), ERROR) is None


def test_intervals_cover_the_truth_as_often_as_they_say():
    """Means of 25 exponential values: a percentile interval covers somewhat less than its 95 %."""
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(300):
        found = summaries.summary(runs(error=rng.exponential(2.0, 25)), Measure("e", "error", "mean"))
        inside += found["low"] <= 2.0 <= found["high"]
    # Binomial: 300 runs at 0.95 have a sigma of 1.3 %.
    assert 0.87 <= inside / 300 <= 0.99


def test_all_of_a_few_runs_is_not_all_of_those_to_come():
    found = summaries.summary(runs(acquired=[True] * 24), SHARE)
    # Clopper and Pearson: 0.025^(1/24).
    assert found["centre"] == 100.0 and found["high"] == 100.0 and found["low"] == pytest.approx(100 * 0.025 ** (1 / 24))


def test_a_few_scenes_have_no_interval():
    found = summaries.summary(runs(error=[1.0, 2.0]), ERROR)
    assert found["centre"] == 1.0 and found["low"] is None and found["high"] is None


def test_where_neither_side_is_better_none_is_called_better():
    found = summaries.paired(runs(nees=[1.0] * 6), runs(nees=[50.0] * 6), Measure("nees", "nees", "median", 0))
    assert found["better"] is None and found["worse"] is None and found["mean"] == pytest.approx(49.0)


def test_the_curve_of_the_first_pose_is_that_of_kaplan_and_meier():
    rows = runs(acquired=[True, True, False, True, False], first_pose_turn_deg=[10.0, 20.0, None, 40.0, None],
                turn_total_deg=[100.0, 100.0, 30.0, 100.0, 100.0])
    # At risk: 5 at 10, 4 at 20, 2 at 40 (one was censored at 30).
    turns, share = summaries.first_pose_curve(rows)
    assert dict(zip(turns, share)) == pytest.approx({0.0: 0.0, 10.0: 0.2, 20.0: 0.4, 30.0: 0.4, 40.0: 0.7, 100.0: 0.7})
    assert summaries.share_by_turn(rows, 25) == pytest.approx(0.4) and summaries.share_by_turn(rows, 5) == 0.0
    assert summaries.share_by_turn(rows, 180) is None
    nobody = runs(acquired=[False, False], first_pose_turn_deg=[None, None], turn_total_deg=[50.0, 60.0])
    assert summaries.share_by_turn(nobody, 45) == 0.0


def test_pairs_are_runs_of_the_very_same_sequence_and_setting():
    base, new = runs(error=[1.0, 2.0, 3.0]), runs(error=[1.5, 2.5, 3.5])
    new[1]["sequence_key"] = "of another seed"
    assert [(a["error"], b["error"]) for a, b in summaries.pairs(base, new)] == [(1.0, 1.5), (3.0, 3.5)]


def test_paired_differences_see_what_spread_between_scenes_hides():
    rng = np.random.default_rng(3)
    base = 10 ** rng.uniform(-2, 1, 30)
    new = base - 0.005 + rng.normal(0, 0.001, 30)
    found = summaries.paired(runs(error=base), runs(error=new), ERROR)
    assert found["mean"] == pytest.approx(-0.005, abs=0.001) and found["high"] < 0 and found["probability"] < 1e-4
    assert (found["pairs"], found["better"], found["worse"]) == (30, 30, 0)


def test_a_pose_in_one_program_only_is_a_gain_or_a_loss():
    found = summaries.paired(runs(first_pose_turn_deg=[5.0, None, None, 8.0]), runs(first_pose_turn_deg=[None, 9.0, None, 8.0]), TURN)
    assert (found["pairs"], found["better"], found["worse"], found["mean"]) == (1, 1, 1, 0.0)
    found = summaries.paired(runs(error=[1.0, None]), runs(error=[None, None]), ERROR)
    assert (found["pairs"], found["better"], found["worse"]) == (0, 0, 1)


def test_the_worst_run_is_the_confidently_wrong_one():
    def row(**values):
        return {"causal_frames_wrong_confident": 0, "smoothed_frames_wrong_confident": 0, "causal_depth_reversed": False,
                "smoothed_depth_reversed": False, "coverage": 1.0, "causal_attitude_rms_deg": 0.1, "scene": "s", "setting": "d"} | values
    rows = [row(), row(coverage=0.0, causal_attitude_rms_deg=None), row(causal_depth_reversed=True), row(causal_frames_wrong_confident=3)]
    assert sorted(rows, key=summaries.badness) == [rows[3], rows[2], rows[1], rows[0]]


def test_every_measure_has_a_title_of_its_own():
    titles = [measure.title for measure in summaries.MEASURES]
    assert len(set(titles)) == len(titles) and {measure.how for measure in summaries.MEASURES} == {"share", "mean", "median", "sum"}
