"""The sample's bus stream as it is recorded for this architecture (tests/golden)."""

import shutil
import subprocess
import sys

import pytest
from polhode_ground.checking import golden
from polhode_ground.testing.replay_files import REPOSITORY


# verifies: CMP-01
@pytest.mark.slow
@pytest.mark.parametrize("name", golden.CONFIGURATIONS)
def test_the_stream_is_the_recorded_one(name, tmp_path):
    same, line = golden.compare(name, golden.stream(name, tmp_path / name))
    assert same, f"{line}\nIf the estimator was meant to change, record anew and say why: tools/golden.py record"


# Six models take 50 minutes: tools/other_processors.py.
@pytest.mark.further
def test_a_processor_with_other_caches_and_without_vector_units_gives_it():
    if not shutil.which("qemu-x86_64-static"):
        pytest.skip("the emulator is not installed: tools/setup.sh processors")
    done = subprocess.run([sys.executable, REPOSITORY / "tools/other_processors.py", "--models", "Nehalem", "--configurations", "default"],
                          capture_output=True, text=True, timeout=3600)
    assert done.returncode == 0, done.stdout + done.stderr
