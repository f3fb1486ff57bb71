"""Sequences without a target: the run ends well, and says that nothing was acquired."""

import re
import subprocess
import sys

import numpy
import pytest
from polhode_ground.testing.replay_files import REPOSITORY, motion_rows, summary
from polhode_ground.testing.sequence_writer import SequenceWriter, noise, textured, uniform

FRAMES = 12

SCENES = {
    "black": lambda index: uniform(0),
    "gray": lambda index: uniform(128),
    "white": lambda index: uniform(255),
    "noise": noise,
    "dark noise": lambda index: (noise(index) // 32).astype(numpy.uint8),
    "static picture": lambda index: textured(1),
}


# verifies: INI-03
@pytest.mark.parametrize("scene", SCENES)
def test_it_ends_in_acquiring_with_exit_0(replay, tmp_path, scene):
    writer = SequenceWriter(tmp_path / "sequence")
    for index in range(FRAMES):
        writer.add(SCENES[scene](index))
    result = replay(writer.path)
    assert result.status == 0, result.err
    rows, told = motion_rows(result.folder), summary(result.folder)
    assert len(rows) == FRAMES
    assert {row["mode"] for row in rows} == {"ACQUIRING"}
    assert {row["pose_valid"] + row["rate_valid"] + row["velocity_valid"] for row in rows} == {"000"}
    assert {row["q_CT_w"] + row["p_CT_x"] + row["w_T_x"] + row["sigma_att_rad"] for row in rows} == {""}
    assert told["acquired"] is False and told["mode_at_end"] == "ACQUIRING"
    assert told["frames"] == {"in": FRAMES, "processed": told["frames"]["processed"], "with_pose": 0, "first_with_pose": None}
    assert "never acquired" in told["result"] and "never acquired" in result.out


def test_its_page_says_so_and_no_surface_is_made(replay, tmp_path):
    writer = SequenceWriter(tmp_path / "sequence")
    for index in range(FRAMES):
        writer.add(noise(index))
    folder = replay(writer.path).folder
    done = subprocess.run([sys.executable, REPOSITORY / "tools/report.py", folder], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    page = (folder / "report.html").read_text()
    shown = re.sub(r"<(script|style).*?</\1>", "", page, flags=re.DOTALL)
    assert "The target was never acquired" in shown and f"0 of {FRAMES}" in shown and "Know this first" in shown
    assert not re.search(r"\bnan\b|\bNone\b", shown), "a value that is not there is shown as one"
    done = subprocess.run([sys.executable, REPOSITORY / "tools/surface.py", folder], capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "0 points, at least 100 are needed" in done.stderr, done.stderr


@pytest.mark.parametrize(("size", "suffix", "config"), [((540, 960), ".png", "default"), ((1080, 1920), ".png", "default")])
def test_upright_pictures_fit_the_configurations(program, tmp_path, size, suffix, config):
    writer = SequenceWriter(tmp_path / "sequence", suffix, *size)
    for index in range(2):
        writer.add(numpy.tile(textured(index), (16, 12))[:size[1], :size[0]])
    done = program("replay", "--config", REPOSITORY / f"config/{config}.toml", "--sequence", writer.path, "--out", tmp_path / "out")
    assert done.status == 0, done.err
    assert summary(tmp_path / "out")["frames"]["processed"] == 2
