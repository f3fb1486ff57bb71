"""The program under test and sequences to feed it with."""

import pathlib
import subprocess
import types

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM, SAMPLE
from polhode_ground.testing.sequence_writer import SequenceWriter, textured


def pytest_collection_modifyitems(config, items):
    here = pathlib.Path(__file__).parent
    if not PROGRAM.exists():
        for item in items:
            if here in item.path.parents:
                item.add_marker(pytest.mark.skip(reason=f"{PROGRAM} is not built"))


@pytest.fixture(scope="session")
def program():
    """Calls the program. @return status, out (text), err (text)."""

    def call(*arguments, timeout_s: float = 600, **options):
        done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=timeout_s, **options)
        return types.SimpleNamespace(status=done.returncode, out=done.stdout, err=done.stderr)

    return call


@pytest.fixture
def replay(program, tmp_path):
    """Replays a sequence into a folder of its own. @return as program, with `folder`."""

    def call(sequence, *arguments, out=None, **options):
        folder = out if out is not None else tmp_path / "out"
        result = program("replay", "--config", DEFAULTS, "--sequence", sequence, "--out", folder, *arguments, **options)
        result.folder = folder
        return result

    return call


@pytest.fixture
def sequence(tmp_path):
    """A good sequence of three frames."""
    writer = SequenceWriter(tmp_path / "sequence")
    for seed in range(3):
        writer.add(textured(seed))
    return writer


@pytest.fixture(scope="session")
def sample():
    if not (SAMPLE / "mav0/cam0/data.csv").exists():
        pytest.skip("hil/data/sample is not there")
    return SAMPLE


@pytest.fixture(scope="session")
def sample_run(program, sample, tmp_path_factory):
    """The sample as the shipped configuration replays it, made once for all who only read it: an error tells that a test
    changed it, as the order of tests differs from run to run. @return as replay, with `sequence`."""
    folder = tmp_path_factory.mktemp("sample") / "out"
    result = program("replay", "--config", DEFAULTS, "--sequence", sample, "--out", folder)
    assert result.status == 0, result.err
    result.folder = folder
    result.sequence = sample
    made = {file.name: file.stat().st_mtime_ns for file in folder.iterdir()}
    yield result
    assert {file.name: file.stat().st_mtime_ns for file in folder.iterdir()} == made, "a test changed the shared run"
