"""The stated camera is tested in flight and at the end of a replay: what is found is told, put into the sigmas, and not used."""

import os
import re

import pytest
from polhode_ground.testing.replay_files import SAMPLE, judged_motion, motion_rows, summary

FOCAL_PX = 888.889
STATED = [FOCAL_PX, FOCAL_PX, 319.5, 239.5]
CONTRADICTED = "The pictures contradict the"


def stating(folder, intrinsics_px):
    """The sample, with other intrinsics [fu, fv, cu, cv] than its own."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    os.symlink(SAMPLE / "mav0/cam0/data", camera / "data")
    for name in ("mav0/cam0/data.csv", "truth.csv", "scene.json", "model.ply"):
        os.symlink(SAMPLE / name, folder / name)
    text = (SAMPLE / "mav0/cam0/sensor.yaml").read_text()
    changed = re.sub(r"intrinsics: \[[^\]]*\]", f"intrinsics: {intrinsics_px}", text)
    assert changed != text
    (camera / "sensor.yaml").write_text(changed)
    return folder


def events(program, folder, name) -> list[str]:
    """The event's lines of a replay's packets."""
    listed = program("bus", "dump", folder / "bus.ccsds")
    assert listed.status == 0, listed.err
    flag = {"focal_length_doubted": "+focal_length_doubted", "camera_contradicted": "camera_contradicted"}[name]
    found = [line for line in listed.out.splitlines() if f"id={name}" in line]
    assert bool(found) == any(flag in line for line in listed.out.splitlines() if "housekeeping" in line), "housekeeping's flag"
    return found


def frame_of(event: str) -> int:
    return int(re.search(r"frame=(\d+)", event)[1])


# verifies: MAP-11
def test_the_right_one_is_borne_out(sample_run, program):
    told = summary(sample_run.folder)
    focal = told["focal_length"]
    assert not focal["refuted"] and told["warnings"] == [] and CONTRADICTED not in told["result"]
    assert abs(focal["found_px"] - FOCAL_PX) < 3 * focal["sigma_px"]
    assert focal["sigma_px"] < 0.02 * FOCAL_PX
    assert not any(one["contradicted"] for one in told["camera"].values())
    assert all(abs(one["off_by"]) < 3 * one["sigma"] for one in told["camera"].values())
    assert events(program, sample_run.folder, "focal_length_doubted") == []
    assert events(program, sample_run.folder, "camera_contradicted") == []


# verifies: MAP-11
@pytest.mark.parametrize(("part", "word"), [(0.85, "more"), pytest.param(1.15, "less", marks=pytest.mark.further)])
def test_a_wrong_focal_length_is_contradicted(replay, sample, program, tmp_path, part, word):
    result = replay(stating(tmp_path / "seq", [part * FOCAL_PX, part * FOCAL_PX, *STATED[2:]]))
    assert result.status == 0, result.err
    told = summary(result.folder)
    focal = told["focal_length"]
    assert focal["refuted"] and abs(focal["given_px"] - part * FOCAL_PX) < 0.01
    assert abs(focal["found_px"] - FOCAL_PX) < 0.5 * abs(part - 1.0) * FOCAL_PX, "most of the way to the true one"
    assert focal["cost_as_found"] < 0.95 * focal["cost_as_given"]
    sentence = re.search(rf"{CONTRADICTED} focal length \[px\]: .* or {word} fits them", told["result"])
    assert sentence and len(told["warnings"]) == 1 and CONTRADICTED in told["warnings"][0]
    assert CONTRADICTED in result.out
    told_in_flight = events(program, result.folder, "focal_length_doubted")
    assert len(told_in_flight) == 1
    given, found = (float(number) for number in re.search(r"length ([\d.]+) px contradicted: ([\d.]+) px fits", told_in_flight[0]).groups())
    assert abs(given - part * FOCAL_PX) < 0.01 and (found > given) == (word == "more")


# verifies: MAP-11
@pytest.mark.parametrize(("stated", "name", "off_by", "word", "in_flight"), [
    ([FOCAL_PX, 1.05 * FOCAL_PX, *STATED[2:]], "log_fv_over_fu", -0.0488, "ratio fv / fu", True),
    pytest.param([*STATED[:3], STATED[3] + 60], "principal_v_over_fv", -60 / FOCAL_PX, "principal point", False, marks=pytest.mark.further)])
def test_another_wrong_statement_is_contradicted_and_in_the_sigmas(replay, sample, program, tmp_path, stated, name, off_by, word, in_flight):
    sequence = stating(tmp_path / "seq", stated)
    result = replay(sequence)
    assert result.status == 0, result.err
    told = summary(result.folder)
    found = told["camera"][name]
    # A map that was made with the stated camera holds the result back.
    assert found["contradicted"] and 0.3 < found["off_by"] / off_by < 1.2
    assert CONTRADICTED in told["result"] and any(f"{CONTRADICTED} {word}" in one for one in told["warnings"])
    assert not told["focal_length"]["refuted"]
    # The test at the end takes all keyframes, those in flight 32.
    if in_flight:
        first = frame_of(events(program, result.folder, "camera_contradicted")[0])
        sigma = {int(row["frame"]): float(row["sigma_att_rad"]) for row in motion_rows(result.folder, "motion.csv") if row["pose_valid"] == "1"}
        assert sigma[first] > 1.5 * sigma[first - 1]
    found = judged_motion(result.folder, sequence, tmp_path / "judgement.json")
    assert found["smoothed"]["attitude"]["rmse_deg"] > 1.0, "what is stated wrong costs accuracy"
    for what in ("attitude", "position"):
        assert found["smoothed"]["consistency"][what]["within_95_percent_bound"] >= 0.97
