"""Sources of every kind out of a few frames of the sample."""

import pathlib
import subprocess
import sys

import pytest
from made_sources import SAMPLE

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def sample():
    from polhode_ground.common.sequence import read_sequence
    return read_sequence(SAMPLE)


@pytest.fixture
def run():
    """import_sequence.py as a user calls it."""
    def call(*arguments):
        return subprocess.run([sys.executable, REPOSITORY / "tools/import_sequence.py", *map(str, arguments)], capture_output=True, text=True)
    return call


@pytest.fixture
def imported(run, tmp_path):
    """(the sequence that was made, standard output) of a call that must end well."""
    def call(source, *arguments, name="SEQ"):
        from polhode_ground.common.sequence import read_sequence
        done = run(source, tmp_path / name, *arguments)
        assert done.returncode == 0, done.stderr
        return read_sequence(tmp_path / name), done.stdout
    return call


@pytest.fixture
def refused(run, tmp_path):
    """The one line of a call that must be refused; nothing may be left behind."""
    def call(source, *arguments):
        done = run(source, tmp_path / "SEQ", *arguments)
        lines = done.stderr.strip().splitlines()
        assert done.returncode == 2 and len(lines) == 1, done.stderr
        assert not (tmp_path / "SEQ").exists() and not (tmp_path / "SEQ.new").exists()
        return lines[0]
    return call
