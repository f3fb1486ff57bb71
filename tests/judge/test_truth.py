"""Truth with a rate and a clock of its own is judged by interpolation, and what is not judged is told."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import read_sequence
from polhode_ground.common.tables import read_motion
from polhode_ground.judge.align import angles_rad, rotations
from polhode_ground.judge.report import text_report
from polhode_ground.judge.run import judge_run, read_run, read_truth, read_truth_for
from polhode_ground.judge.truth import Matching, at_frames, estimated_offset
from polhode_ground.testing.synthetic import TRUTH_HEADER, Errors, tumbling_body, write_run, write_sequence
from test_evaluate import REPOSITORY

FRAMES, RATE_HZ = 60, 49.7  # every tenth frame has a row's stamp by chance, the others lie between rows
ATTITUDE_RMS_RAD = 0.002


@pytest.fixture(scope="module")
def body():
    return tumbling_body(FRAMES)


@pytest.fixture(scope="module")
def made(tmp_path_factory, body):
    """(sequence, run) whose errors are known."""
    folder = tmp_path_factory.mktemp("truth")
    sequence = write_sequence(folder / "seq", body)
    run = write_run(folder / "run", body, Errors(attitude_rms_rad=ATTITUDE_RMS_RAD), sequence=sequence)
    (run / "cloud.ply").unlink()
    return read_sequence(sequence), read_run(run)


def write_truth(path, ahead_ns: int = 0, kept=lambda time_s: True, turning=True):
    """Of a motion capture: RATE_HZ, its clock ahead by so much."""
    fine = tumbling_body(round(FRAMES * RATE_HZ), 1 / RATE_HZ, turning=turning)
    rows = np.column_stack([fine.p_CT, fine.R_CT.as_quat(scalar_first=True), fine.v_C, fine.w_T])
    lines = [",".join([str(stamp + ahead_ns), *map(repr, map(float, row))]) for stamp, row, time_s in zip(fine.timestamp_ns, rows, fine.time_s) if kept(time_s)]
    path.write_text("\n".join([",".join(TRUTH_HEADER), *lines]) + "\n")
    return path


# verifies: GND-02
def test_a_motion_capture_is_interpolated_at_the_frames(made, body, tmp_path):
    """Slerp between rows 0.02 s apart strays from the true turn by rate * nutation * gap^2 / 8 < 1e-6 rad."""
    sequence, run = made
    truth = read_truth(sequence, write_truth(tmp_path / "truth.csv"))
    at = np.isin(truth.timestamp_ns, body.timestamp_ns)
    assert np.array_equal(truth.timestamp_ns[at], body.timestamp_ns)
    assert angles_rad(rotations(truth.q_CT[at]), body.R_CT).max() < 1e-6
    assert np.allclose(truth.p_CT[at], body.p_CT, atol=1e-9) and np.allclose(truth.w_T[at], body.w_T, atol=1e-6)
    report = judge_run(run, sequence, truth)
    assert report["motion"]["causal"]["attitude"]["rmse_deg"] == pytest.approx(np.degrees(ATTITUDE_RMS_RAD), rel=0.05)
    assert report["motion"]["causal"]["target_frames"]["poses_judged"] == FRAMES
    text = text_report([report])
    assert "poses judged" in text and "truth: interpolated at 54 of 60 frames, between rows at most 0.25 s apart" in text


def test_rows_too_far_apart_are_not_bridged(made, tmp_path):
    sequence, run = made
    path = write_truth(tmp_path / "truth.csv", kept=lambda time_s: not 20 < time_s < 40.5)
    report = judge_run(run, sequence, read_truth(sequence, path))
    assert report["motion"]["causal"]["target_frames"]["poses_judged"] == 40
    assert "20 of 60 frames have no truth" in report["truth"] and "40 of 60 poses are judged" in text_report([report])
    bridged = read_truth(sequence, path, Matching(gap_max_s=25))
    assert judge_run(run, sequence, bridged)["motion"]["causal"]["target_frames"]["poses_judged"] == 60


def test_rows_without_a_pose_are_stepped_over(made, tmp_path):
    sequence, _ = made
    path = write_truth(tmp_path / "truth.csv")
    lines = path.read_text().splitlines()
    row = 1 + round(11 * RATE_HZ)  # beside frame 11
    lines[row] = lines[row].split(",")[0] + "," * 13
    path.write_text("\n".join(lines))
    truth = read_truth(sequence, path)
    assert truth.pose_valid[np.isin(truth.timestamp_ns, sequence.timestamp_ns)].all() and "interpolated at 54" in truth.remark


@pytest.mark.parametrize(("divisor", "says"), [(1_000, "these look like"), (1_000_000, "these look like")])
def test_rows_in_another_unit_are_refused_by_its_name(made, tmp_path, divisor, says):
    sequence, _ = made
    lines = write_truth(tmp_path / "truth.csv").read_text().splitlines()
    rows = [f"{int(line.split(',', 1)[0]) // divisor},{line.split(',', 1)[1]}" for line in lines[1:]]
    (tmp_path / "truth.csv").write_text("\n".join([lines[0], *rows]) + "\n")
    unit = {1_000: "microseconds", 1_000_000: "milliseconds"}[divisor]
    with pytest.raises(BadInput, match=f"are no nanoseconds: {says} .*{unit}"):
        at_frames(read_motion(tmp_path / "truth.csv"), sequence.timestamp_ns, Matching())


def test_truth_that_was_made_for_the_frames_stays_as_it_is(made):
    sequence, _ = made
    own = read_motion(sequence.truth_path)
    truth = read_truth(sequence)
    assert np.array_equal(truth.q_CT, own.q_CT) and truth.remark == ""
    # A frame that has none has none on purpose: its stamp may be wrong.
    kept = np.arange(FRAMES) % 4 > 0
    some = replace(own, **{name: getattr(own, name)[kept] for name in ("timestamp_ns", "q_CT", "p_CT", "v_C", "w_T", "pose_valid", "rate_valid", "velocity_valid",
                                                                      "scale_known")}, columns={})
    assert len(at_frames(some, sequence.timestamp_ns, Matching(gap_max_s=10)).timestamp_ns) == kept.sum()


# verifies: GND-02
@pytest.mark.parametrize("offset_s", [1.37, -0.4])
def test_the_offset_of_the_clock_is_estimated(made, tmp_path, offset_s):
    """Noise alone: ATTITUDE_RMS_RAD over the frames' root and the change of attitude that no constant rotation undoes, 0.6 deg/s here."""
    sequence, run = made
    path = write_truth(tmp_path / "truth.csv", round(offset_s * 1e9))
    found = estimated_offset(run.motions["smoothed"], read_motion(path))
    expected_s = ATTITUDE_RMS_RAD / np.sqrt(FRAMES) / np.radians(0.6)
    assert abs(found.offset_s - offset_s) < 3 * expected_s < found.offset_sigma_s
    assert "estimated from the motion" in at_frames(read_motion(path), sequence.timestamp_ns, found).remark
    exact = read_truth(sequence, path, Matching(offset_s=offset_s))
    assert judge_run(run, sequence, exact)["motion"]["causal"]["attitude"]["rmse_deg"] == pytest.approx(np.degrees(ATTITUDE_RMS_RAD), rel=0.05)


def test_an_offset_that_the_motion_does_not_tell_is_refused(made, tmp_path):
    sequence, run = made
    path = write_truth(tmp_path / "truth.csv", turning=False)
    still = tumbling_body(FRAMES, turning=False)
    resting = read_run(write_run(tmp_path / "run", still, Errors(attitude_rms_rad=ATTITUDE_RMS_RAD)))
    with pytest.raises(BadInput, match="the motion does not tell it"):
        read_truth_for(resting, sequence.timestamp_ns, path, Matching(offset_s=None))
    far = write_truth(tmp_path / "far.csv", 3600 * 10**9)
    with pytest.raises(BadInput, match="no clock gives half of the frames"):
        read_truth_for(run, sequence.timestamp_ns, far, Matching(offset_s=None))
    with pytest.raises(BadInput, match="from 3600 s to 3659.* s after the first frame.*a clock of its own"):
        read_truth(sequence, far)


def test_evaluate_and_report_take_it_and_its_options(made, tmp_path):
    sequence, run = made
    path = write_truth(tmp_path / "truth.csv", 300_000_000)
    for tool, arguments in (("hil/evaluate.py", (run.folder, sequence.folder)), ("tools/report.py", (run.folder, "--sequence", sequence.folder))):
        done = subprocess.run([sys.executable, REPOSITORY / tool, *arguments, "--truth", path, "--clock-offset", "0.3"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    refused = subprocess.run([sys.executable, REPOSITORY / "hil/evaluate.py", run.folder, sequence.folder, "--truth-gap-s", "0"], capture_output=True, text=True)
    assert refused.returncode == 2 and "--truth-gap-s" in refused.stderr


# verifies: GND-02
def test_rows_of_a_truth_that_are_no_numbers_are_named(made, tmp_path):
    sequence, run = made
    path = write_truth(tmp_path / "truth.csv")
    head, *rows = path.read_text().splitlines()
    column = head.split(",").index("q_CT_w")

    def with_nan(row, text="nan"):
        cells = row.split(",")
        return ",".join([*cells[:column], text, *cells[column + 1:]])
    path.write_text("\n".join([head, *map(with_nan, rows)]) + "\n")
    done = subprocess.run([sys.executable, REPOSITORY / "hil/evaluate.py", run.folder, sequence.folder, "--truth", path], capture_output=True, text=True)
    assert done.returncode == 2 and f"truth.csv:2: no row of {len(rows)} has a whole pose: the quaternion q_CT has empty or nan cells" in done.stderr
    path.write_text("\n".join([head, *rows[:7], *(with_nan(row, "") for row in rows[7:10]), *rows[10:]]) + "\n")
    truth = read_truth(sequence, path)
    assert f"3 of its {len(rows)} rows have a part of a pose and are not used, the first in line 9" in text_report([judge_run(run, sequence, truth)])
