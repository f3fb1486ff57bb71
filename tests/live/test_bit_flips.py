"""Bits flipped in the tables of a live run. hil/seu_campaign.py does it hundreds of times."""

import json
import pathlib
import subprocess
import sys

import numpy
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import read_motion
from polhode_ground.faults import service, verdict
from polhode_ground.faults.tables import symbol_address
from polhode_ground.testing.replay_files import REPOSITORY
from scipy.spatial.transform import Rotation

TRUTH = REPOSITORY / "hil/data/sample/truth.csv"


class Packet:
    def __init__(self, **values):
        self.__dict__ = values


def motion(time_ns, q_CT, sigma_deg=0.2):
    return Packet(name="motion", timestamp_ns=time_ns, q_CT=q_CT, pose_valid=q_CT is not None, sigma_att_rad=numpy.radians(sigma_deg))


def turned(q, angle_deg):
    """About the target's z."""
    return list((Rotation.from_quat(q, scalar_first=True) * Rotation.from_euler("z", angle_deg, degrees=True)).as_quat(scalar_first=True))


def start(packets, begun="start cold: no checkpoint", end="status 0"):
    return service.Start(begun, end, "", packets)


@pytest.fixture
def truth():
    return read_motion(TRUTH)


def judged(starts, truth, flipped=10):
    return {"flipped": True, **verdict.account(starts, truth, int(truth.timestamp_ns[flipped]))}


def published(truth, off_from=99, sigma_deg=0.2):
    """In a T that is turned against the truth's; from that frame on 8 deg off."""
    return [motion(int(time_ns), turned(q, 30.0 + (8.0 if i >= off_from else 0.0)), sigma_deg)
            for i, (time_ns, q) in enumerate(zip(truth.timestamp_ns, truth.q_CT))]


def test_a_constant_rotation_is_no_error(truth):
    one = judged([start(published(truth))], truth)
    assert one["kind"] == "clean" and verdict.faults_of(one) == []


def test_wrong_with_a_small_sigma_is_a_fault_and_with_a_large_one_none(truth):
    one = judged([start(published(truth, off_from=20))], truth)
    assert one["kind"] == "wrong pose" and len(one["wrong_poses"]) == 70
    assert one["wrong_poses"][0]["error_deg"] == pytest.approx(8.0, abs=0.1)
    assert verdict.faults_of(one) == ["a wrong pose with a small sigma"]
    assert judged([start(published(truth, off_from=20, sigma_deg=3.0))], truth)["kind"] == "clean"


def test_a_map_begun_anew_has_axes_of_its_own(truth):
    packets = published(truth, off_from=20)
    event = Packet(name="event", id=verdict.TARGET_ACQUIRED, timestamp_ns=int(truth.timestamp_ns[20]), text="")
    damaged = Packet(name="event", id=verdict.TABLE_DAMAGED, timestamp_ns=int(truth.timestamp_ns[11]), text="map damaged")
    one = judged([start([*packets, event, damaged])], truth)
    assert one["kind"] == "reset" and verdict.faults_of(one) == []


def test_a_crash_has_to_come_back(truth):
    packets = published(truth)
    crashed = start(packets[:12], end="signal SIGSEGV")
    back = start(packets[14:], begun="start warm: from frame 10, 0.3 s ago")
    one = judged([crashed, back], truth)
    assert one["kind"] == "crash" and verdict.faults_of(one) == []
    none = [motion(int(time_ns), None) for time_ns in truth.timestamp_ns[14:18]]
    late = start([*none, *packets[18:]], begun="start warm: from frame 10, 0.3 s ago")
    assert verdict.faults_of(judged([crashed, late], truth)) == ["warm, and no pose within 3 frames"]
    cold = start(none, begun="start cold: 2 runs in a row crashed soon after their start")
    assert verdict.faults_of(judged([crashed, cold], truth)) == ["cold, and not acquired again"]
    assert verdict.faults_of(judged([crashed], truth)) == ["down for good"]


def test_a_stripped_program_is_refused(tmp_path):
    with pytest.raises(BadInput, match="no symbol polhode_tables"):
        symbol_address(pathlib.Path("/bin/true"))


@pytest.mark.further
def test_flipped_and_found_by_the_scrubber(tmp_path):
    """4096 flips hit the map with near certainty (22 of its 63 MB are the map's)."""
    done = subprocess.run([sys.executable, REPOSITORY / "hil/seu_campaign.py", tmp_path / "runs", "--runs", "1", "--flips", "0,4096",
                           "--watchdog-s", "60"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    control, flipped = json.loads((tmp_path / "runs/campaign.json").read_text())["runs"]
    assert control["kind"] == "clean" and control["damage_reported"] == []
    assert flipped["kind"] in ("reset", "crash") and flipped["wrong_poses"] == []
