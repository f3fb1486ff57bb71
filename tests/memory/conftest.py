"""The soak program and what it found."""

import json
import os
import pathlib
import subprocess
import types

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SOAK = pathlib.Path(os.environ.get("POLHODE_SOAK", REPOSITORY / "build/release/bin/polhode_soak"))
SAMPLE = REPOSITORY / "hil/data/sample"


@pytest.fixture(scope="session")
def soak():
    """Runs frames of the sample back and forth after the seal. @return status, err, found (what it printed)."""
    if not SOAK.exists():
        pytest.skip(f"{SOAK} is not built: fixed memory is off in this build")

    def call(frames: int, *arguments: str):
        done = subprocess.run(
            [SOAK, "--config", REPOSITORY / "config/default.toml", "--sequence", SAMPLE, "--frames", str(frames), *arguments],
            capture_output=True, text=True, timeout=3 * 3600)
        found = json.loads(done.stdout) if done.stdout.startswith("{") else None
        return types.SimpleNamespace(status=done.returncode, err=done.stderr, found=found)

    return call
