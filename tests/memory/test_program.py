"""The program's memory from outside: the plan, its refusal, and what a run says that it used."""

import json
import pathlib
import subprocess

import numpy
import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")


def call(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=600)


@pytest.fixture
def sequence(tmp_path):
    writer = SequenceWriter(tmp_path / "sequence")
    for seed in range(4):
        writer.add(textured(seed))
    return writer.path


def test_the_plan_names_tables_pools_calls_and_stacks(sequence):
    result = call("check", "--config", DEFAULTS, "--sequence", sequence, "--memory")
    assert result.returncode == 0, result.stderr
    for part in ("keyframes", "landmarks", "general", "reserve", "optical flow", "stack of the jobs", "in all", "It fits."):
        assert part in result.stdout


def test_the_plan_needs_a_camera():
    result = call("check", "--config", DEFAULTS, "--memory")
    assert result.returncode == 2
    assert "--sequence" in result.stderr


@pytest.mark.parametrize("setting", ["budget.total_mb=64", "budget.step_mb=4"])
def test_what_does_not_fit_is_refused_before_the_start(tmp_path, setting):
    key = setting.split("=")[0]
    writer = SequenceWriter(tmp_path / "large", width=1920, height=1080)
    writer.add(numpy.zeros((1080, 1920), numpy.uint8))
    large = writer.path
    checked = call("check", "--config", DEFAULTS, "--sequence", large, "--set", setting)
    assert checked.returncode == 2 and key in checked.stderr
    replayed = call("replay", "--config", DEFAULTS, "--sequence", large, "--out", tmp_path / "out", "--set", setting)
    assert replayed.returncode == 2 and key in replayed.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("budget", "width", "height"), [("standard", 640, 480), ("standard", 1280, 720), ("full", 640, 480), ("full", 1920, 1080)])
def test_the_budgets_hold_the_sample_and_their_own_picture(tmp_path, budget, width, height):
    writer = SequenceWriter(tmp_path / "sequence", width=width, height=height)
    writer.add(numpy.zeros((height, width), numpy.uint8))
    result = call("check", "--config", REPOSITORY / f"config/{budget}.toml", "--sequence", writer.path, "--memory")
    assert result.returncode == 0, result.stderr
    assert "It fits." in result.stdout


def test_colour_of_the_largest_kind_replays_where_its_plan_fits(tmp_path):
    """3840x2160, three channels, noise: files of 25 MB, as large as such pictures get."""
    writer = SequenceWriter(tmp_path / "sequence", width=3840, height=2160)
    random = numpy.random.default_rng(1)
    for _ in range(2):
        writer.add(random.integers(0, 256, (2160, 3840, 3), numpy.uint8))
    arguments = ["--config", DEFAULTS, "--sequence", writer.path, "--set", "budget.step_mb=128", "--set", "budget.total_mb=512"]
    checked = call("check", *arguments, "--memory")
    assert checked.returncode == 0, checked.stderr
    result = call("replay", *arguments, "--out", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    stays_in_its_pools(tmp_path / "out")


def test_a_run_stays_in_its_pools(sequence, tmp_path):
    result = call("replay", "--config", DEFAULTS, "--sequence", sequence, "--out", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    stays_in_its_pools(tmp_path / "out")


def stays_in_its_pools(out):
    summary = json.loads((out / "summary.json").read_text())
    assert summary["counters"]["frames_unreadable"] == 0
    memory = summary["memory"]
    assert memory["budget_octets"] >= memory["planned_octets"]
    if not memory["fixed"]:
        pytest.skip("fixed memory is off in this build")
    for name, pool in memory["pools"].items():
        assert pool["peak_octets"] <= pool["octets"], name
    assert memory["pools"]["reserve"]["peak_octets"] == 0
    assert summary["counters"]["steps_short_of_memory"] == 0
