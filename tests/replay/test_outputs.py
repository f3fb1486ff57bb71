"""The files of a replay: complete, of one mind with each other, and as the interface document has them."""

import hashlib
import json
import math
import subprocess
import sys

import numpy
import pytest
from PIL import Image
from polhode_ground.testing.replay_files import REPOSITORY, motion_rows, summary
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

HEADER = (
    "frame,timestamp_ns,mode,pose_valid,rate_valid,velocity_valid,scale_known,"
    "q_CT_w,q_CT_x,q_CT_y,q_CT_z,p_CT_x,p_CT_y,p_CT_z,v_C_x,v_C_y,v_C_z,w_T_x,w_T_y,w_T_z,"
    "sigma_att_rad,sigma_pos,sigma_vel,sigma_rate_rad_s,features,matches,inliers,landmarks,keyframes,step_us,target_frame,scale_number"
)
FILES = {
    "motion.csv", "motion_smoothed.csv", "trajectory.tum", "causal.tum", "smoothed.tum", "cloud_raw.ply", "cloud.ply", "surface.ply", "shape.json",
    "motion_model.json", "bus.ccsds", "summary.json", "observations.csv", ".polhode-replay",
}
GROUPS = {
    "pose_valid": ["q_CT_w", "q_CT_x", "q_CT_y", "q_CT_z", "p_CT_x", "p_CT_y", "p_CT_z", "sigma_att_rad", "sigma_pos",
                   "target_frame", "scale_number"],
    "rate_valid": ["w_T_x", "w_T_y", "w_T_z", "sigma_rate_rad_s"],
    "velocity_valid": ["v_C_x", "v_C_y", "v_C_z", "sigma_vel"],
}


@pytest.fixture(params=["short", "sample"])
def run(request):
    if request.param == "sample":
        return request.getfixturevalue("sample_run")
    sequence = request.getfixturevalue("sequence").path
    result = request.getfixturevalue("replay")(sequence)
    assert result.status == 0, result.err
    result.sequence = sequence
    return result


# verifies: PRG-03
def test_every_file_is_there_and_no_other(run):
    assert {file.name for file in run.folder.iterdir()} == FILES


# verifies: PRG-03
@pytest.mark.parametrize("name", ["motion.csv", "motion_smoothed.csv"])
def test_motion_tables_have_the_header_and_a_row_a_frame(run, name):
    lines = (run.folder / name).read_text().splitlines()
    assert lines[0] == HEADER
    stamps = [line.split(",")[0] for line in (run.sequence / "mav0/cam0/data.csv").read_text().splitlines()
              if not line.startswith("#")]
    rows = motion_rows(run.folder, name)
    assert [row["timestamp_ns"] for row in rows] == stamps
    assert [row["frame"] for row in rows] == [str(i) for i in range(len(stamps))]
    for row in rows:
        assert row["mode"] in ("IDLE", "ACQUIRING", "TRACKING", "COASTING", "LOST")
        for flag, columns in GROUPS.items():
            assert row[flag] in ("0", "1")
            for column in columns:
                assert (row[column] != "") == (row[flag] == "1"), (row["frame"], column)
                assert row[column] == "" or math.isfinite(float(row[column]))
        if row["pose_valid"] == "1":
            q = [float(row[f"q_CT_{axis}"]) for axis in "wxyz"]
            assert math.isclose(math.hypot(*q), 1.0, abs_tol=1e-6)


# verifies: MOT-10
def test_quaternions_do_not_jump_in_sign(run):
    poses = [numpy.array([float(row[f"q_CT_{axis}"]) for axis in "wxyz"])
             for row in motion_rows(run.folder) if row["pose_valid"] == "1"]
    assert all(a @ b >= 0.0 for a, b in zip(poses, poses[1:]))


# verifies: BUS-04
def test_bus_holds_one_motion_packet_a_frame_with_the_rows_values(run, program):
    packets = [json.loads(line) for line in program("bus", "dump", run.folder / "bus.ccsds", "--json").out.splitlines()]
    packets = [packet for packet in packets if packet["packet"] == "motion"]
    rows = motion_rows(run.folder)
    assert len(packets) == len(rows)
    for index, (packet, row) in enumerate(zip(packets, rows)):
        assert packet["sequence"] == index % 16384
        assert str(packet["timestamp_ns"]) == row["timestamp_ns"] and packet["mode"] == row["mode"]
        assert str(int(packet["pose_valid"])) == row["pose_valid"]
        if packet["pose_valid"]:
            assert packet["p_CT"] == pytest.approx([float(row[f"p_CT_{axis}"]) for axis in "xyz"], rel=1e-8)
        if packet["rate_valid"]:
            assert packet["w_T_rad_s"] == pytest.approx([float(row[f"w_T_{axis}"]) for axis in "xyz"], rel=1e-8)


def test_summary_tells_what_the_interface_document_lists(run):
    told = summary(run.folder)
    rows = motion_rows(run.folder)
    assert told["version"] == "0.1.0" and len(told["config_hash"]) == 64
    assert told["sequence"] == str(run.sequence)
    assert told["bus"]["sha256"] == hashlib.sha256((run.folder / "bus.ccsds").read_bytes()).hexdigest()
    assert told["frames"]["in"] == len(rows) == told["counters"]["frames_in"]
    assert told["frames"]["with_pose"] == sum(row["pose_valid"] == "1" for row in rows)
    assert told["acquired"] == (told["frames"]["with_pose"] > 0)
    for stage in ("read", "step", "image", "mask", "features", "tracks", "map", "shape", "motion", "bus"):
        times = told["timings"][stage]
        assert times["p50_us"] <= times["p95_us"] <= times["p99_us"] <= times["max_us"]
    assert told["timings"]["step"]["count"] == len(rows)
    assert told["memory"]["peak_resident_octets"] > told["memory"]["budget_octets"] / 100
    changes = [(row["frame"], row["mode"]) for row, before in zip(rows, [{"mode": ""}, *rows]) if row["mode"] != before["mode"]]
    assert [(str(entry["frame"]), entry["mode"]) for entry in told["mode_history"]] == changes


def test_observations_table_is_sorted_by_frame_and_whole(run):
    lines = (run.folder / "observations.csv").read_text().splitlines()
    assert lines[0] == "frame,timestamp_ns,landmark,u_px,v_px,predicted_u_px,predicted_v_px,inlier"
    frames = [int(line.split(",")[0]) for line in lines[1:]]
    assert frames == sorted(frames)
    assert all(line.count(",") == 7 for line in lines)


def test_landmarks_of_the_cloud_are_those_of_the_observations(run):
    header, _, body = (run.folder / "cloud_raw.ply").read_bytes().partition(b"end_header\n")
    count = int(header.split(b"element vertex ")[1].split()[0])
    if count == 0:
        return
    assert header.splitlines()[-4:] == [b"property float x", b"property float y", b"property float z", b"property int landmark"]
    points = numpy.frombuffer(body, dtype=[("p", "<f4", 3), ("landmark", "<i4")])
    assert len(points) == count == len(set(points["landmark"]))
    lines = (run.folder / "observations.csv").read_text().splitlines()[1:]
    seen = {int(line.split(",")[2]) for line in lines if line.split(",")[2]}
    # The newest are confirmed by keyframes before them and need not have been seen since.
    assert len(set(points["landmark"].tolist()) & seen) > 0.9 * count


FORMATS = {
    "png 8": (".png", lambda image: image),
    "pgm 8": (".pgm", lambda image: image),
    "png rgb": (".png", lambda image: numpy.dstack([image] * 3)),
}


# verifies: PRG-02
def test_lossless_formats_of_the_same_picture_give_the_same_packets(replay, tmp_path):
    hashes = {}
    for name, (suffix, convert) in FORMATS.items():
        writer = SequenceWriter(tmp_path / name, suffix)
        for seed in range(4):
            writer.add(convert(textured(seed)))
        result = replay(writer.path, out=tmp_path / f"out {name}")
        assert result.status == 0, result.err
        hashes[name] = summary(result.folder)["bus_sha256"]
    assert len(set(hashes.values())) == 1, hashes


# verifies: PRG-02
@pytest.mark.parametrize(("suffix", "depth"), [(".png", 16), (".pgm", 16), (".jpg", 8)])
def test_other_formats_are_read(replay, tmp_path, suffix, depth):
    writer = SequenceWriter(tmp_path / "sequence", suffix)
    for seed in range(3):
        writer.add(textured(seed).astype(numpy.uint16) * 257 if depth == 16 else textured(seed))
    result = replay(writer.path)
    assert result.status == 0, result.err
    assert summary(result.folder)["frames"]["processed"] == 3
    assert max(int(row["features"]) for row in motion_rows(result.folder)) > 20


def test_masks_and_tracks_are_written_where_wished_and_can_be_drawn(replay, sequence):
    result = replay(sequence.path, "--masks")
    assert result.status == 0, result.err
    assert {file.name for file in result.folder.iterdir()} == FILES | {"masks.pgms", "mask_tracks.csv"}
    done = subprocess.run([sys.executable, REPOSITORY / "tools/plot_masks.py", result.folder, sequence.path], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
    for frame in range(3):
        picture = numpy.asarray(Image.open(result.folder / f"plots/overlay_{frame:06d}.png").convert("L"))
        assert picture.std() > 10, frame


# verifies: MAP-09
def test_target_frame_numbers_the_frames_of_the_poses(sample, replay, tmp_path):
    stamps = [line.split(",")[0] for line in (sample / "mav0/cam0/data.csv").read_text().splitlines()[1:]]
    commands = tmp_path / "commands.txt"
    commands.write_text(f"{stamps[40]} reset_map\n")
    result = replay(sample, "--commands", commands)
    assert result.status == 0, result.err
    rows = motion_rows(result.folder)
    numbers = [(int(row["frame"]), int(row["target_frame"])) for row in rows if row["target_frame"]]
    assert {number for frame, number in numbers if frame < 40} == {1}
    assert {number for frame, number in numbers if frame >= 40} == {2}
    smoothed = {row["target_frame"] for row in motion_rows(result.folder, "motion_smoothed.csv")}
    assert smoothed <= {"2", ""} and "2" in smoothed, "all of a re-estimation is in the last map's frame"
