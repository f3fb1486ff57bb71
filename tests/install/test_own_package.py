"""The ground's Python is one installed package: what workers, entry points and commands import is the same wherever they are started."""

import os
import pathlib
import re
import subprocess
import sys
import tomllib

import polhode_ground
import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = tomllib.loads((REPOSITORY / "tools/pyproject.toml").read_text())["project"]["scripts"]
COMMANDS = {file: found[1] for folder in ("tools", "hil") for file in sorted((REPOSITORY / folder).glob("*.py"))
            if (found := re.search(r"^from (polhode_ground\.\S+) import command$", file.read_text(), re.MULTILINE))}
# As a worker of a cluster has it: no variable of ours, another folder.
BARE = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "POLHODE"))}


def test_every_command_is_an_entry_point_of_its_name():
    assert len(COMMANDS) > 30
    assert SCRIPTS == {f"polhode-{file.stem.replace('_', '-')}": f"{module}:command" for file, module in COMMANDS.items()}


def test_a_command_does_no_work_of_its_own():
    long = {file.name: lines for file in COMMANDS if (lines := len(file.read_text().splitlines())) > 10}
    assert not long


@pytest.mark.parametrize("module", ["polhode_ground.campaigns.tasks", "polhode_ground.scenes.truth", "polhode_bus"])
def test_it_is_imported_in_any_folder_from_this_one(tmp_path, module):
    done = subprocess.run([sys.executable, "-c", f"import {module} as one; print(one.__file__)"], capture_output=True, text=True, cwd=tmp_path, env=BARE)
    assert done.returncode == 0, done.stderr
    assert pathlib.Path(done.stdout.strip()).is_relative_to(REPOSITORY)


def test_an_entry_point_prints_its_help(tmp_path):
    done = subprocess.run([pathlib.Path(sys.executable).parent / "polhode-evaluate", "--help"], capture_output=True, text=True, cwd=tmp_path, env=BARE)
    assert done.returncode == 0 and done.stdout.startswith("usage: polhode-evaluate"), done.stderr


def test_hil_finds_the_very_same_files():
    link = REPOSITORY / "hil/polhode_ground"
    assert link.is_symlink() and link.resolve() == pathlib.Path(polhode_ground.__file__).resolve().parent
