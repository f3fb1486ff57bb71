"""What a run found as an MCAP file of Foxglove's schemas, read back by mcap's own decoder."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from polhode_ground.common.tables import read_motion
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.judge.shape import read_cloud
from polhode_ground.testing.synthetic import FOCAL_PX, START_NS, write_acquired

FRAMES = 20


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return write_acquired(tmp_path_factory.mktemp("foxglove"), frames=FRAMES)


def convert(*arguments):
    return subprocess.run([sys.executable, REPOSITORY / "tools/sequence_to_mcap.py", *map(str, arguments)], capture_output=True, text=True)


@pytest.fixture(scope="module")
def messages(made, tmp_path_factory):
    """{topic: [(log time, message)]}; JSON messages are dictionaries."""
    file = tmp_path_factory.mktemp("mcap") / "run.mcap"
    done = convert(made[0], "--run", made[1], "--out", file)
    assert done.returncode == 0 and f"{FRAMES} images" in done.stdout, done.stderr
    found = {}
    with open(file, "rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.message_encoding == "protobuf":
                assert schema.name.startswith("foxglove.") and schema.encoding == "protobuf"
                decoded = DecoderFactory().decoder_for("protobuf", schema)(message.data)
            else:
                decoded = json.loads(message.data)
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


@pytest.mark.parametrize("kind", ["causal", "smoothed"])
def test_each_pose_is_a_transform_at_its_time(made, messages, kind):
    motion = read_motion(made[1] / {"causal": "motion.csv", "smoothed": "motion_smoothed.csv"}[kind])
    rows = np.flatnonzero(motion.pose_valid)
    found = messages[f"/target/{kind}"]
    assert [time_ns for time_ns, _ in found] == motion.timestamp_ns[rows].tolist() and len(rows) == FRAMES - 3
    for row, (time_ns, transform) in zip(rows, found):
        assert (transform.parent_frame_id, transform.child_frame_id) == ("C", f"T_{kind}")
        assert transform.timestamp.ToNanoseconds() == time_ns
        at, turn = transform.translation, transform.rotation
        assert [at.x, at.y, at.z] == motion.p_CT[row].tolist()
        assert [turn.w, turn.x, turn.y, turn.z] == motion.q_CT[row].tolist()


def test_the_cloud_hangs_on_the_smoothed_frame(made, messages):
    (_, cloud), = messages["/target/cloud"]
    assert cloud.frame_id == "T_smoothed" and cloud.pose.orientation.w == 1.0
    place = {field.name: field.offset for field in cloud.fields}
    rows = np.frombuffer(cloud.data, dtype=np.dtype({"names": ["x", "y", "z", "sigma"], "formats": ["<f4"] * 4, "itemsize": cloud.point_stride,
                                                     "offsets": [place[name] for name in ("x", "y", "z", "sigma")]}))
    points = read_cloud(made[1] / "cloud.ply")
    assert np.allclose(np.stack([rows[name] for name in "xyz"], axis=1), points, atol=1e-6) and len(points) == 600
    assert np.isnan(rows["sigma"]).all()  # this cloud has none


def test_pictures_and_camera_are_in_the_same_frame(messages):
    assert {image["frame_id"] for _, image in messages["/camera/image"]} == {"C"} and len(messages["/camera/image"]) == FRAMES
    (_, camera), = messages["/camera/calibration"]
    assert camera.frame_id == "C" and camera.K[0] == FOCAL_PX and camera.distortion_model == "plumb_bob"


def test_events_are_words_at_their_time(made):
    from polhode_ground.reporting.foxglove_messages import messages_of
    from polhode_ground.reporting.gather import gather
    material = gather(made[1], made[0])
    material.events = [SimpleNamespace(header=SimpleNamespace(seconds=START_NS // 10**9 + 4, fraction=2**23), text="the scale is known")]
    (time_ns, event), = [(time_ns, message) for topic, time_ns, message in messages_of(material) if topic == "/target/events"]
    assert time_ns == event.timestamp.ToNanoseconds() == START_NS + 4_500_000_000
    assert event.message == "the scale is known" and event.level == event.INFO


def test_a_run_that_is_none_is_refused_and_leaves_the_file(made, tmp_path):
    (tmp_path / "run.mcap").write_text("earlier")
    done = convert(made[0], "--run", tmp_path, "--out", tmp_path / "run.mcap")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and str(tmp_path) in done.stderr, done.stderr
    assert (tmp_path / "run.mcap").read_text() == "earlier" and len(list(tmp_path.iterdir())) == 1
