"""hil/paper_table.sh from end to end, with a renderer and an estimator that are quick stand-ins of the same command line."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest
from polhode_ground.testing.synthetic import Errors, tumbling_body, write_run, write_sequence

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
RENDER = """#!/bin/sh
# render_scene.sh SCENE OUT [--variant NAME]
echo "render $*" >> "$CALLS"
mkdir -p "$2" && cp -r "$MADE/seq/." "$2"
"""
ESTIMATOR = """#!/bin/sh
# polhode replay --config C --sequence S --out O [--set ...]...
echo "polhode $*" >> "$CALLS"
[ -z "$BROKEN" ] || { echo "polhode: broken" >&2; exit 1; }
mkdir -p "$7" && cp -r "$MADE/run/." "$7"
"""


@pytest.fixture
def house(tmp_path):
    """A copy of the scripts beside the stand-ins, and a made-up scene and run for these to hand out."""
    root = tmp_path / "house"
    for folder in ("hil/scenes", "tools", "build/release/bin", "config", ".venv/bin"):
        (root / folder).mkdir(parents=True)
    for name in ("hil/paper_table.sh", "hil/evaluate.py", "tools/plot_replay.py"):
        shutil.copy(REPOSITORY / name, root / name)
    for name in ("hil/polhode_ground", "tools/polhode_ground"):
        (root / name).symlink_to(REPOSITORY / "tools/polhode_ground")
    (root / ".venv/bin/python3").symlink_to(sys.executable)
    for name, text in (("hil/render_scene.sh", RENDER), ("build/release/bin/polhode", ESTIMATOR)):
        (root / name).write_text(text)
        (root / name).chmod(0o755)
    for case in ("2d", "3d"):
        (root / f"hil/scenes/paper_{case}.toml").write_text("")
    body = tumbling_body(frames=24)
    sequence = write_sequence(tmp_path / "made/seq", body)
    (sequence / "scene.json").write_text(
        '{"known_lengths": [{"name": "panel_long_edge", "length_m": 0.06, "points_px": [[1, 2], [3, 4]],'
        ' "frame_timestamp_ns": 1700000000000000000}]}')
    write_run(tmp_path / "made/run", body, Errors(rate_rms_rad_s=0.001), sequence=sequence)
    return root


def call(house, *arguments, **extra):
    base = house.parent
    environment = os.environ | {"POLHODE_CACHE": str(base / "cache"), "CALLS": str(base / "calls"), "MADE": str(base / "made"),
                                "BROKEN": "", "PATH": f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"} | extra
    return subprocess.run([house / "hil/paper_table.sh", *arguments], capture_output=True, text=True, env=environment)


# verifies: MOT-12
@pytest.mark.further
def test_both_cases_are_rendered_replayed_judged_drawn_and_tabled(house):
    done = call(house, "--small", "--set", "seed=3")
    assert done.returncode == 0, done.stderr
    calls = (house.parent / "calls").read_text().splitlines()
    assert [line.split()[0] for line in calls] == ["render", "polhode", "render", "polhode"]
    assert calls[0].endswith("paper_2d_small --variant small")
    assert "scale.known_length_m=0.06" in calls[1] and "scale.frame_timestamp_ns=1700000000000000000" in calls[1]
    assert calls[1].endswith("--set seed=3")
    table = done.stdout.split("figures beside ours")[1]
    assert "2D angular velocity, mean relative error" in table and "3D w_y RMSE" in table
    assert "Points and features over time" in table and table.count("\n2D ") > table.count("\n3D w_") >= 2
    replays = house.parent / "cache/replays"
    assert (replays / "paper_3d_small.json").exists() and (replays / "paper_3d_small/plots/rates.png").exists()


def test_a_failed_replay_ends_with_status_1_and_names_the_case(house):
    done = call(house, "--case", "3d", BROKEN="1")
    assert done.returncode == 1
    assert "paper_3d: the replay failed" in done.stderr


def test_a_missing_estimator_is_refused_before_anything_is_rendered(house):
    (house / "build/release/bin/polhode").unlink()
    done = call(house)
    assert done.returncode == 2 and "build it first" in done.stderr
    assert not (house.parent / "calls").exists()
