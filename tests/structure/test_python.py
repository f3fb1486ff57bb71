"""The ground's Python is linted and formatted by ruff, and typed strictly where others build on it: tools/pyproject.toml has the rules."""

import pathlib
import subprocess
import sys

import pytest
from source_tree import REPOSITORY

RUFF = pathlib.Path(sys.executable).parent / "ruff"
CONFIG = REPOSITORY / "tools/pyproject.toml"


def found_by(*command) -> str:
    """What the tool complains of; empty where nothing is wrong."""
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=600, cwd=REPOSITORY / "tools")
    return "" if done.returncode == 0 else done.stdout + done.stderr


@pytest.mark.parametrize("arguments", [("check", "--quiet", "--output-format=concise"), ("format", "--quiet", "--check")], ids=["lint", "format"])
def test_ruff_finds_nothing(arguments):
    wrong = found_by(RUFF, *arguments, "--config", CONFIG, REPOSITORY / "tools", REPOSITORY / "hil")
    assert not wrong, f".venv/bin/ruff {arguments[0]} --config tools/pyproject.toml tools hil\n{wrong}"


def test_types_hold_strictly():
    wrong = found_by(sys.executable, "-m", "mypy", "--config-file", CONFIG)
    assert not wrong, f"cd tools; ../.venv/bin/python -m mypy\n{wrong}"


def test_the_tools_complain_at_all(tmp_path):
    (tmp_path / "bad.py").write_text("import os\nx = {  'a':1}\n\n\ndef f(a):\n    return a\n")
    assert "F401" in found_by(RUFF, "check", "--config", CONFIG, tmp_path)
    assert "bad.py" in found_by(RUFF, "format", "--check", "--config", CONFIG, tmp_path)
    assert "no-untyped-def" in found_by(sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", tmp_path / "bad.py")
