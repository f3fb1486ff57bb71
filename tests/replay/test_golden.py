"""The sample's bus stream as it is recorded for this architecture (tests/golden)."""

import pathlib
import sys

import pytest
from replay_files import REPOSITORY

sys.path.insert(0, str(pathlib.Path(REPOSITORY) / "tools"))

import golden  # noqa: E402
from first_difference import first_difference, packets  # noqa: E402


# verifies: CMP-01
@pytest.mark.slow
@pytest.mark.parametrize("name", golden.CONFIGURATIONS)
def test_the_stream_is_the_recorded_one(name, tmp_path):
    expected = golden.recorded() / f"{name}.ccsds"
    if not expected.exists():
        pytest.skip(f"nothing is recorded for {golden.architecture()}")
    if not golden.comparable(name):
        pytest.skip(f"recorded with another processor than {golden.processor()}")
    found = golden.stream(name, tmp_path / name)
    if expected.read_bytes() != found.read_bytes():
        difference = first_difference(packets(expected), packets(found)) or "headers or check sums differ"
        pytest.fail(f"{difference}\nIf the estimator was meant to change, record anew and say why: tools/golden.py record")
