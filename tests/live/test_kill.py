"""A run that is killed at random moments goes on from its checkpoint. hil/kill_campaign.py does it fifty times."""

import json
import subprocess
import sys

import pytest
from polhode_ground.testing.replay_files import REPOSITORY


# verifies: LIV-03
@pytest.mark.further
def test_killed_three_times_and_found_again(tmp_path):
    done = subprocess.run([sys.executable, REPOSITORY / "hil/kill_campaign.py", tmp_path / "runs", "--kills", "3", "--interval-s", "0.5"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    verdict = json.loads((tmp_path / "runs/campaign.json").read_text())["verdict"]
    assert verdict["kills"] == 3 and verdict["cold_starts"] == 0
