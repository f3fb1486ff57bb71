"""The tools that measure cost and compare streams: on made-up input whose answer is known."""


import pytest
from polhode_ground.checking import benchmark_table, first_difference, instruction_counts
from polhode_ground.importing import scale_sequence

PACKETS = [{"frame": 0, "mode": "acquiring", "q_CT": [1.0, 0.0, 0.0, 0.0]}, {"frame": 1, "mode": "tracking", "q_CT": [0.6, 0.8, 0.0, 0.0]}]


def test_equal_streams_have_no_difference():
    assert first_difference.first_difference(PACKETS, [dict(p) for p in PACKETS]) is None


def test_the_first_differing_field_is_named():
    other = [dict(PACKETS[0]), {**PACKETS[1], "q_CT": [0.6, 0.8, 0.0, 1e-17], "mode": "lost"}]
    text = first_difference.first_difference(PACKETS, other)
    assert text.startswith("packet 1, mode: expected 'tracking', found 'lost'")
    assert "1 other fields" in text


def test_a_missing_packet_is_a_difference():
    assert "expected 2 packets, found 1" in first_difference.first_difference(PACKETS, PACKETS[:1])


def test_a_missing_field_is_a_difference():
    assert "mode" in first_difference.first_difference(PACKETS, [{"frame": 0, "q_CT": [1.0, 0.0, 0.0, 0.0]}, PACKETS[1]])


ANNOTATION = """\
--------------------------------------------------------------------------------
Ir                     file:function
--------------------------------------------------------------------------------
9,000,000 (90.0%)  fsw/pipeline/step.cpp:polhode::Component::step(polhode::StepInput const&) [/x/polhode]
2,000,000 (20.0%)  ???:polhode::detect_features(cv::Mat const&, polhode::TargetMask const&) [/x/polhode]
1,500,000 (15.0%)  ???:polhode::detect_features(cv::Mat const&, polhode::TargetMask const&)'2 [/x/polhode]
"""


def test_counts_are_read_from_the_annotation():
    counts = instruction_counts.inclusive_counts(ANNOTATION)
    assert counts["polhode::Component::step"] == 9_000_000
    assert counts["polhode::detect_features"] == 2_000_000


# verifies: RES-05
def test_only_a_stage_that_costs_more_is_reproached():
    recorded = {"step": 100.0, "mask": 2.0}
    assert instruction_counts.verdicts(recorded, {"step": 109.0, "mask": 1.0}) == []
    assert instruction_counts.verdicts(recorded, {"step": 111.0, "mask": 2.0})[0].startswith("step: 111.0")


def test_the_table_leaves_out_what_never_ran():
    span = {"count": 3, "p50_us": 1500, "p95_us": 2000, "p99_us": 2500, "max_us": 3000}
    cpu = {"cpu_p50_us": 1400, "cpu_p95_us": 1500, "cpu_p99_us": 1600, "cpu_max_us": 1700}
    table = benchmark_table.rows({"step": {**span, **cpu}, "read": span, "job": {**span, "count": 0}})
    assert [row[0] for row in table] == ["", "step", "read"]
    assert table[1][2:] == ("1.50", "2.00", "2.50", "3.00", "1.40", "1.50", "1.60", "1.70")
    assert table[2][2:] == ("1.50", "2.00", "2.50", "3.00", "", "", "", "")


@pytest.mark.parametrize("u", [-0.5, 0.0, 319.5])
def test_a_scaled_camera_sees_the_same_ray_at_the_scaled_pixel(u):
    fu, fv, cu, cv = 888.0, 888.0, 319.5, 239.5
    gu, _, du, _ = scale_sequence.scaled_intrinsics([fu, fv, cu, cv], 2.25, 240, 0)
    scaled_u = (u + 0.5) * 2.25 - 0.5 + 240
    assert abs((scaled_u - du) / gu - (u - cu) / fu) < 1e-12
