"""A campaign of two tiny scenes, end to end: rendered, transformed, replayed, judged, reported; with workers and the scheduler
killed on the way, and the same tables all the same."""

import csv
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import pyarrow.parquet
import pytest
from polhode_ground.campaigns import results
from polhode_ground.common.venv import REPOSITORY

PROGRAM = REPOSITORY / "build/release/bin/polhode"
PLAN = """
name = "tiny"
[scenes]
draws = 2
seed = 7
frames = 16
resolution = [240, 180]
texture_px = 256
samples = 4
[scenes.space]
body = "cubesat"
motion = "tumble"
background = { none = 1, stars = 1 }
blur = "none"
size_px = [100, 120]
turn_deg = [2.5, 3.5]
phase_deg = [30, 60]
[[transforms]]
name = "gaps"
steps = [{ kind = "missing", fraction = 0.2 }]
[[configurations]]
name = "default"
file = "config/default.toml"
"""
RUNS = 2 * 2

pytestmark = [pytest.mark.slow,
              pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built"),
              pytest.mark.skipif(shutil.which("blender") is None, reason="Blender is not installed (tools/setup.sh renderer)")]


def words(plan, out, cache, *more):
    return [sys.executable, str(REPOSITORY / "hil/campaign.py"), str(plan), "--out", str(out), "--cache", str(cache), "--workers", "2", *more]


def run(plan, out, cache, *more, status=0):
    done = subprocess.run(words(plan, out, cache, *more), capture_output=True, text=True, timeout=600)
    assert done.returncode == status, done.stdout + done.stderr
    return done


def write_plan(folder: pathlib.Path, text=PLAN) -> pathlib.Path:
    path = folder / "plan.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """(plan, folder, cache) of a campaign that nobody disturbed."""
    folder = tmp_path_factory.mktemp("campaign")
    plan = write_plan(folder)
    done = run(plan, folder / "out", folder / "cache")
    assert "target acquired [% of runs]" in done.stdout and f"judge {RUNS}/{RUNS}" in done.stderr and "none failed" in done.stderr
    return plan, folder / "out", folder / "cache"


def tables(out) -> tuple[list[dict], list[dict]]:
    """Rows of both tables without times and places."""
    rows = pyarrow.parquet.read_table(out / "report/runs.parquet").to_pylist()
    rows = [{name: value for name, value in row.items() if not name.startswith(results.COST) and not name.endswith("_folder")} for row in rows]
    return rows, pyarrow.parquet.read_table(out / "report/frames.parquet").to_pylist()


def made(out) -> dict[str, int]:
    """What is done, with the times at which it was."""
    places = [path for kind in ("runs", "results", "times") for path in (out / kind).glob("*")]
    return {str(path.relative_to(out)): path.stat().st_mtime_ns for path in places if not path.name.startswith(".") and ".part-" not in path.name}


def test_the_report_has_a_row_a_run_and_a_row_a_frame(undisturbed):
    _, out, _ = undisturbed
    rows, frames = tables(out)
    assert len(rows) == RUNS and {(row["scene"], row["transform"], row["setting"]) for row in rows} == {
        (scene, transform, "default") for scene in ("draw_000", "draw_001") for transform in ("plain", "gaps")}
    assert len(frames) == sum(row["frames"] for row in rows)
    assert {row["frames"] for row in rows if row["transform"] == "plain"} == {16}
    assert {row["frames"] for row in rows if row["transform"] == "gaps"} == {13}
    assert all(2.5 <= row["point_turn_deg"] <= 3.5 for row in rows)
    timed = pyarrow.parquet.read_table(out / "report/runs.parquet").to_pylist()
    assert all(row["cost_cpu_ms_a_frame"] > 0 and row["cost_step_cpu_longest_ms"] >= row["cost_step_cpu_median_ms"] for row in timed)


def test_the_page_and_its_tables_can_be_read(undisturbed):
    _, out, _ = undisturbed
    page = (out / "report/index.html").read_text()
    assert f"{RUNS} of {RUNS} runs are judged" in page and 'src="data:image/png;base64,' in page
    assert "http" not in page and "<script" not in page, "it needs nothing from elsewhere"
    links = [part.split('"', 1)[0] for part in page.split('href="')[1:]]
    assert len(links) > 3 and all((out / "report" / link).is_file() for link in links)
    with open(out / "report/summary.csv") as stream:
        summary = list(csv.DictReader(stream))
    acquired = [row for row in summary if row["measure"] == "target acquired [% of runs]"]
    assert len(acquired) == 2 and all(row["of"] == "2" and 0 <= float(row["centre"]) <= 100 for row in acquired)


@pytest.mark.further
def test_a_rerun_does_nothing_and_a_new_question_only_what_is_missing(undisturbed, tmp_path):
    plan, out, cache = undisturbed
    before = made(out)
    run(plan, out, cache)
    assert made(out) == before
    other = write_plan(tmp_path, PLAN + "[judge]\nshape = false\n")
    done = run(other, out, cache)
    assert f"judge {RUNS}/{RUNS}" in done.stderr and "replay" not in done.stderr and "render" not in done.stderr
    after = made(out)
    assert {name: after[name] for name in before} == before
    assert sum(name.startswith("results/") for name in after) == 2 * RUNS
    run(plan, out, cache)


def paired(out) -> list[dict]:
    with open(out / "report/paired.csv") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.further
def test_two_campaigns_are_set_side_by_side(undisturbed, tmp_path):
    plan, out, cache = undisturbed
    done = subprocess.run([sys.executable, REPOSITORY / "hil/campaign.py", "--report", out, "--vs", out], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    rows = paired(out)
    assert rows and all(row["better"] in ("0", "") and row["worse"] in ("0", "") for row in rows), "a campaign differs from itself in nothing"
    changed = write_plan(tmp_path, PLAN.replace('file = "config/default.toml"', 'file = "config/default.toml"\nset = ["features.count_max=100"]')
                         + "[judge]\ntime_alone = false\n")
    run(changed, tmp_path / "out", cache, "--vs", str(out))
    assert any(row["better"] not in ("0", "") or row["worse"] not in ("0", "") for row in paired(tmp_path / "out"))
    assert "Paired differences" in (tmp_path / "out/report/index.html").read_text()


def children(pid: int) -> list[int]:
    """Dask's worker processes below a campaign."""
    found = []
    for status in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rsplit(")", 1)[1].split()
            command = (status.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if int(fields[1]) == pid and b"spawn_main" in command:
            found.append(int(status.parent.name))
    return found


def wait_until(condition, process, timeout_s=240.0):
    until = time.monotonic() + timeout_s
    while not condition():
        assert process.poll() is None and time.monotonic() < until, "the campaign ended, or took too long"
        time.sleep(0.05)


def count(folder, pattern="*") -> int:
    return len([path for path in folder.glob(pattern) if not path.name.startswith(".")]) if folder.is_dir() else 0


@pytest.mark.further
def test_kills_change_no_table(undisturbed, tmp_path):
    """A worker while it renders, later another while it replays, then scheduler and workers at once; then to the end."""
    plan, whole, _ = undisturbed
    out, cache = tmp_path / "out", tmp_path / "cache"
    process = subprocess.Popen(words(plan, out, cache), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_until(lambda: count(cache / "scenes", "*/mav0/cam0/data/*.png") >= 2, process)
    os.kill(children(process.pid)[0], signal.SIGKILL)
    wait_until(lambda: count(out / "runs") >= 1, process)
    os.kill(children(process.pid)[-1], signal.SIGKILL)
    wait_until(lambda: count(out / "results") >= 2, process)
    process.kill()
    process.wait()
    done_by_then = made(out)
    again = run(plan, out, cache)
    assert "none failed" in again.stderr
    after = made(out)
    assert {name: after[name] for name in done_by_then} == done_by_then, "what was done is not done again"
    assert tables(out) == tables(whole)
    assert not list((out / "runs").glob("*.part-*"))


@pytest.mark.further
def test_a_task_that_fails_stops_nothing_else(undisturbed, tmp_path):
    _, _, cache = undisturbed
    plan = write_plan(tmp_path, PLAN + '[[configurations]]\nname = "refused"\nfile = "config/full.toml"\nset = ["mask.no_such_key=1"]\n'
                      + "[judge]\ntime_alone = false\n")
    done = run(plan, tmp_path / "out", cache, status=1)
    assert done.stderr.count("campaign: replay of ") == 4 and "mask.no_such_key" in done.stderr and "4 tasks that need them were not tried" in done.stderr
    rows, _ = tables(tmp_path / "out")
    assert {row["setting"] for row in rows} == {"default"} and len(rows) == 4
    failures = json.loads((tmp_path / "out/failures.json").read_text())
    assert len(failures) == 8 and all(pathlib.Path(one["log"]).is_file() for one in failures if one["log"])
    assert "8 tasks failed" in (tmp_path / "out/report/index.html").read_text()


def test_a_report_can_be_had_at_any_time(undisturbed, tmp_path):
    _, out, _ = undisturbed
    copy = tmp_path / "half"
    shutil.copytree(out, copy)
    for entry in json.loads((copy / "campaign.json").read_text())["runs"][2:]:
        shutil.rmtree(copy / "results" / entry["result"])
    done = subprocess.run([sys.executable, REPOSITORY / "hil/campaign.py", "--report", copy], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert f"2 of {RUNS} runs are judged" in (copy / "report/index.html").read_text()
