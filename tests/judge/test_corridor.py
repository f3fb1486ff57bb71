"""The corridor of the C example against the truth that its host has not seen, and on the page of a run."""

import csv
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest
from polhode_ground.common.tables import read_motion
from polhode_ground.judge import align
from polhode_ground.judge.aligned import align_last
from polhode_ground.reporting.corridor import open_spans, read_corridor
from polhode_ground.testing.synthetic import write_acquired

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("POLHODE_BUILD", REPOSITORY / "build/release"))
EXAMPLE, PROGRAM = BUILD / "bin/polhode_corridor_example", BUILD / "bin/polhode"
SAMPLE = REPOSITORY / "hil/data/sample"
SEEN, FRAMES = 60, 90
pytestmark = pytest.mark.skipif(not EXAMPLE.exists() or "POLHODE_RUNNER" in os.environ, reason=f"{EXAMPLE} is not built for this machine")


def run(*command) -> subprocess.CompletedProcess:
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> pathlib.Path:
    """The sample's first frames."""
    folder = tmp_path_factory.mktemp("short") / "SEQ"
    (folder / "mav0/cam0").mkdir(parents=True)
    rows = (SAMPLE / "mav0/cam0/data.csv").read_text().splitlines()[:SEEN + 1]
    (folder / "mav0/cam0/data.csv").write_text("\n".join(rows) + "\n")
    for name in ("sensor.yaml", "data"):
        (folder / "mav0/cam0" / name).symlink_to(SAMPLE / "mav0/cam0" / name)
    return folder


def corridor(short: pathlib.Path, out: pathlib.Path, face: str) -> tuple[np.ndarray, np.ndarray, list[dict[str, float]]]:
    """(centre_T, normal_T, rows of OUT.csv)"""
    done = run(EXAMPLE, short, out, face, FRAMES - SEEN)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    told = [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", done.stdout.split("centre_T")[1].split(", frame")[0])]
    with out.open() as file:
        rows = [{name.lstrip("#"): float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]
    assert len(rows) == FRAMES - SEEN + 1
    return np.array(told[:3]), np.array(told[3:]), rows


@pytest.fixture(scope="module")
def aligned(short, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "DIR"
    assert run(PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", short, "--out", folder).returncode == 0
    return align_last(read_motion(folder / "motion.csv"), read_motion(SAMPLE / "truth.csv"))


# verifies: MOT-14
@pytest.mark.parametrize("face", ["0", "1"])
def test_the_face_is_where_the_corridor_has_it(short, aligned, tmp_path, face):
    centre_E, normal_E, rows = corridor(short, tmp_path / "corridor.csv", face)
    truth, similarity = read_motion(SAMPLE / "truth.csv"), aligned.own_similarity
    centre_T = similarity.scale * aligned.R_ET.inv().apply(centre_E - similarity.offset_E)
    normal_T = aligned.R_ET.inv().apply(normal_E)
    for ahead in range(FRAMES - SEEN):
        row, frame = rows[ahead], SEEN - 1 + ahead
        assert row["known"] == 1 and row["ahead_s"] == ahead
        R_CT = align.rotations(truth.q_CT[frame])
        p_C = R_CT.apply(centre_T) + truth.p_CT[frame]
        off = np.linalg.norm(similarity.scale * np.array([row[f"p_C_{axis}"] for axis in "xyz"]) - p_C)
        # 3.3 sigma: 99.9 % of one axis; sigma_p is that of the worst one at least. Half a per cent of the range is what a servicer can use
        assert off < 3.3 * similarity.scale * row["sigma_p"] and off < 0.005 * np.linalg.norm(p_C), ahead
        normal_C = np.array([row[f"normal_C_{axis}"] for axis in "xyz"])
        angle_deg = np.degrees(np.arccos(min(1.0, float(normal_C @ R_CT.apply(normal_T)))))
        assert angle_deg < 3.7 * row["sigma_normal_deg"] and angle_deg < 2.0, ahead  # two components
        facing_deg = np.degrees(np.arccos(-p_C @ normal_C / np.linalg.norm(p_C)))
        assert abs(row["facing_deg"] - facing_deg) < 0.1
        assert row["open"] == (facing_deg < 60 and row["half_angle_deg"] > 0)


def test_the_example_refuses_in_words(short, tmp_path):
    for arguments, status, says in [([short, tmp_path / "out", "0"], 2, "usage:"), ([short, tmp_path / "out", "0", "601"], 2, "AHEAD_S: 0 .. 600"),
                                    (["NOT_THERE", tmp_path / "out", "0", "1"], 2, "cannot be opened"), ([short, "NOT_THERE/out", "0", "1"], 2, "cannot be written"),
                                    ([short, tmp_path / "out", "77", "1"], 1, "face 77: the last shape packet has"), ([short, tmp_path / "out", "one", "1"], 1, "face one:")]:
        done = run(EXAMPLE, *arguments)
        assert done.returncode == status and done.stderr.count("\n") == 1 and says in done.stderr, done.stderr


HEADER = "#timestamp [ns],ahead_s,known,p_C_x,p_C_y,p_C_z,normal_C_x,normal_C_y,normal_C_z,sigma_p,sigma_normal_deg,facing_deg,half_angle_deg,open\n"
ROWS = "".join(f"{1_000_000_000 * second},{second},1,0,0,{9 - second / 10},0,0.6,-0.8,0.01,{second / 20},36.9,{15 - second / 6.7},{int(5 <= second < 9)}\n" for second in range(12))


def test_the_page_has_the_corridor(tmp_path):
    run_folder = write_acquired(tmp_path, frames=12)[1]
    (run_folder / "corridor.csv").write_text(HEADER + ROWS + "12000000000,12,0,0,0,0,0,0,0,0,0,0,0,0\n")
    found = read_corridor(run_folder / "corridor.csv")
    assert open_spans(found) == [(5.0, 8.0)] and np.isnan(found["facing_deg"][12])
    done = run(sys.executable, REPOSITORY / "tools/report.py", run_folder)
    assert done.returncode == 0 and "Where it may be approached" in (run_folder / "report.html").read_text(), done.stderr


def test_a_table_that_is_no_corridor_is_told_on_the_page(tmp_path):
    run_folder = write_acquired(tmp_path, frames=12)[1]
    (run_folder / "corridor.csv").write_text("ahead_s,known\n1,1\n")
    assert run(sys.executable, REPOSITORY / "tools/report.py", run_folder).returncode == 0
    page = (run_folder / "report.html").read_text()
    assert "Where it may be approached" not in page and "The corridor is left out" in page and "no column p_C_x" in page
