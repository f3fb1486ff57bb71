"""The focal length is tested in flight and at the end of a replay; its value is told and not used."""

import os
import re

import pytest
from replay_files import SAMPLE, summary

FOCAL_PX = 888.889
CONTRADICTED = "The pictures contradict the focal length"


def with_focal(folder, part: float):
    """The sample, with a focal length that is `part` of the true one."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    os.symlink(SAMPLE / "mav0/cam0/data", camera / "data")
    os.symlink(SAMPLE / "mav0/cam0/data.csv", camera / "data.csv")
    text = (SAMPLE / "mav0/cam0/sensor.yaml").read_text()
    changed = re.sub(r"intrinsics: \[[^,]*, [^,]*,", f"intrinsics: [{part * FOCAL_PX}, {part * FOCAL_PX},", text)
    assert changed != text
    (camera / "sensor.yaml").write_text(changed)
    return folder


def doubts(program, folder) -> list[str]:
    """The event's lines of a replay's packets."""
    listed = program("bus", "dump", folder / "bus.ccsds")
    assert listed.status == 0, listed.err
    assert ("+focal_length_doubted" in listed.out) == ("id=focal_length_doubted" in listed.out), "housekeeping's flag"
    return [line for line in listed.out.splitlines() if "id=focal_length_doubted" in line]


# verifies: MAP-11
def test_the_right_one_is_borne_out(sample_run, program):
    told = summary(sample_run.folder)
    focal = told["focal_length"]
    assert not focal["refuted"] and told["warnings"] == [] and CONTRADICTED not in told["result"]
    assert abs(focal["found_px"] - FOCAL_PX) < 3 * focal["sigma_px"]
    assert focal["sigma_px"] < 0.02 * FOCAL_PX
    assert doubts(program, sample_run.folder) == []


# verifies: MAP-11
@pytest.mark.parametrize(("part", "word"), [(0.85, "more"), (1.15, "less")])
def test_a_wrong_one_is_refuted(replay, sample, program, tmp_path, part, word):
    result = replay(with_focal(tmp_path / "seq", part))
    assert result.status == 0, result.err
    told = summary(result.folder)
    focal = told["focal_length"]
    assert focal["refuted"] and abs(focal["given_px"] - part * FOCAL_PX) < 0.01
    assert abs(focal["found_px"] - FOCAL_PX) < 0.5 * abs(part - 1.0) * FOCAL_PX, "most of the way to the true one"
    assert focal["cost_as_found"] < 0.95 * focal["cost_as_given"]
    sentence = re.search(rf"{CONTRADICTED}: .* px or {word} fits them", told["result"])
    assert sentence and len(told["warnings"]) == 1 and CONTRADICTED in told["warnings"][0]
    assert CONTRADICTED in result.out
    told_in_flight = doubts(program, result.folder)
    assert len(told_in_flight) == 1
    given, found = (float(number) for number in re.search(r"length ([\d.]+) px contradicted: ([\d.]+) px fits", told_in_flight[0]).groups())
    assert abs(given - part * FOCAL_PX) < 0.01 and (found > given) == (word == "more")
