"""Stamps that are not those of the pictures: no rate is published of them, and an event says so."""

import math
import os

from polhode_ground.testing.replay_files import SAMPLE, motion_rows, summary

FRAMES = 26
FIRST_NS = 1_700_000_000_000_000_000
MS = 1_000_000


def restamped(folder, stamps_ns: list[int], rate_hz: float):
    """The sample's first pictures with other times."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    os.symlink(SAMPLE / "mav0/cam0/data", camera / "data")
    names = [line.split(",")[1] for line in (SAMPLE / "mav0/cam0/data.csv").read_text().splitlines() if line[0] != "#"]
    rows = [f"{stamp},{name.strip()}" for stamp, name in zip(stamps_ns, names)]
    (camera / "data.csv").write_text("#timestamp [ns],filename\n" + "\n".join(rows) + "\n")
    text = (SAMPLE / "mav0/cam0/sensor.yaml").read_text()
    (camera / "sensor.yaml").write_text(text.replace("rate_hz: 1.0", f"rate_hz: {rate_hz}"))
    return folder


def test_stamps_of_arrival_give_no_rate(replay, program, sample, tmp_path):
    arrival = [FIRST_NS + 400 * MS * (i // 4) + 5 * MS * (i % 4) for i in range(FRAMES)]
    result = replay(restamped(tmp_path / "seq", arrival, 10.0))
    assert result.status == 0, result.err
    assert "intervals are over 6 times the median" in result.err
    for name in ("motion.csv", "motion_smoothed.csv"):
        posed = [row for row in motion_rows(result.folder, name) if row["pose_valid"] == "1"]
        assert len(posed) >= 5, "there are poses of several bursts"
        assert [row["frame"] for row in posed if row["rate_valid"] == "1"] == [], name
    listed = program("bus", "dump", result.folder / "bus.ccsds").out
    assert listed.count("time stamps doubted: intervals 0.005 to 0.385 s") == 1
    assert "turning at" not in summary(result.folder)["result"]


def test_rates_that_no_debris_has_are_an_event(replay, program, sample, tmp_path):
    result = replay(restamped(tmp_path / "seq", [FIRST_NS + MS * i for i in range(FRAMES)], 1000.0))
    assert result.status == 0, result.err
    row = [row for row in motion_rows(result.folder) if row["rate_valid"] == "1"][-1]
    rate_deg_s = math.degrees(math.hypot(*(float(row[f"w_T_{axis}"]) for axis in "xyz")))
    assert rate_deg_s > 3000.0
    listed = program("bus", "dump", result.folder / "bus.ccsds").out
    assert listed.count("deg/s: faster than debris turns") == 1


def test_the_samples_own_stamps_are_not_doubted(replay, program, sample, tmp_path):
    result = replay(restamped(tmp_path / "seq", [FIRST_NS + 1000 * MS * i for i in range(FRAMES)], 1.0))
    assert result.status == 0 and "warning" not in result.err, result.err
    listed = program("bus", "dump", result.folder / "bus.ccsds").out
    assert "doubted" not in listed and "debris" not in listed
    assert any(row["rate_valid"] == "1" for row in motion_rows(result.folder))
