"""tools/export.py: what other libraries than the writers' read of its files is motion.csv, and what has no pose is in none of them.

Orekit's reading of the CCSDS messages is in test_export_orekit.py.
"""

import csv
import platform
import re
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from exported import KM, MISSING, POSES, RUNS, SCALED, call, quaternion_error_rad, stamp, target_of, write_eventful
from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import read_motion
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.testing.synthetic import MOTION_HEADER

ATTITUDE_MAX_RAD = 1e-9
NS = 10**9
GOLDEN = REPOSITORY / "tests/golden" / platform.machine() / "default.ccsds"


@pytest.fixture(scope="module")
def eventful(tmp_path_factory):
    return write_eventful(tmp_path_factory.mktemp("export") / "run")


@pytest.fixture
def run(eventful, tmp_path):
    return shutil.copytree(eventful, tmp_path / "run")


@pytest.fixture(scope="module")
def motion(eventful):
    return read_motion(eventful / "motion.csv")


def nanoseconds(text: str) -> int:
    return int(np.datetime64(text, "ns").astype(np.int64))


# verifies: GND-06
def test_an_aem_as_xml_has_a_segment_for_each_run_of_frames_and_each_t(run, motion, tmp_path):
    call(run, "--format", "aem", "--out", tmp_path / "a.xml")
    segments = ElementTree.parse(tmp_path / "a.xml").getroot().findall("body/segment")
    assert len(segments) == len(RUNS)
    for segment, (first, last) in zip(segments, RUNS):
        said = {one.tag: one.text for one in segment.find("metadata") if one.tag != "COMMENT"}
        assert said["REF_FRAME_A"] == "CAMERA" and said["REF_FRAME_B"] == f"SC_BODY_{target_of(first)}" and said["TIME_SYSTEM"] == "UTC"
        assert (nanoseconds(said["START_TIME"]), nanoseconds(said["STOP_TIME"])) == (stamp(first), stamp(last))
        frames = list(range(first, last + 1))
        assert [nanoseconds(one.text) for one in segment.iter("EPOCH")] == [stamp(frame) for frame in frames]
        read = np.array([[float(one.find(name).text) for name in ("QC", "Q1", "Q2", "Q3")] for one in segment.iter("quaternion")])
        assert quaternion_error_rad(read, motion.q_CT[frames]) < ATTITUDE_MAX_RAD


# verifies: GND-06
def test_an_aem_as_kvn_has_the_same_numbers(run, motion):
    call(run, "--format", "aem", "--clock", "tai")
    text = (run / "motion.aem").read_text()
    lines = [line.split() for line in text.splitlines() if re.match(r"\d{4}-", line)]
    assert [nanoseconds(line[0]) for line in lines] == [stamp(frame) for frame in POSES]
    assert quaternion_error_rad(np.roll(np.array([line[1:] for line in lines], dtype=float), 1, axis=1), motion.q_CT[POSES]) < ATTITUDE_MAX_RAD
    assert text.count("TIME_SYSTEM          = TAI") == len(RUNS) and "2 of them are COASTING" in text


# verifies: GND-06
def test_an_apm_is_the_asked_frames_attitude_with_rates_in_degrees(run, motion):
    call(run, "--format", "apm", "--frame", 12, "--rates")
    said = dict(re.findall(r"^(\w+) += (\S+)$", (run / "motion.apm").read_text(), re.MULTILINE))
    assert nanoseconds(said["EPOCH"]) == stamp(12)
    assert quaternion_error_rad(np.array([[float(said[name]) for name in ("QC", "Q1", "Q2", "Q3")]]), motion.q_CT[[12]]) < ATTITUDE_MAX_RAD
    assert np.allclose([float(said[f"ANGVEL_{axis}"]) for axis in "XYZ"], np.degrees(motion.w_T[12]), rtol=1e-12)


# verifies: GND-06
@pytest.mark.parametrize("file", ["a.oem", "a.xml"])
def test_an_oem_read_by_another_library_is_in_km_from_the_first_known_scale_on(run, motion, tmp_path, file):
    from oem import OrbitEphemerisMessage
    call(run, "--format", "oem", "--out", tmp_path / file)
    message = OrbitEphemerisMessage.open(tmp_path / file)
    frames = [frame for frame in POSES if frame >= SCALED]
    states = [state for segment in message for state in segment.states]
    assert len(message.segments) == len(RUNS) and len(states) == len(frames)
    unix_ns = [round((state.epoch.utc.jd1 - 2440587.5) * 86400) * NS + round(state.epoch.utc.jd2 * 86400 * NS) for state in states]
    assert np.abs(np.array(unix_ns) - [stamp(frame) for frame in frames]).max() <= 1  # astropy's two floats of days
    assert np.allclose([state.position for state in states], motion.p_CT[frames] * KM, rtol=1e-12)
    assert np.allclose([state.velocity for state in states], motion.v_C[frames] * KM, rtol=1e-12, atol=1e-18)
    covariances = [one.matrix for segment in message for one in segment.covariances]
    assert len(covariances) == len(frames) and np.allclose(covariances, np.diag([0.02**2] * 3 + [0.003**2] * 3) * KM**2, rtol=1e-12)


def ck_records(file) -> dict[int, tuple]:
    """{instrument: (ticks, quaternions, interval starts)} of type 3 segments, by jplephem's reader of DAF and NAIF's description of the type."""
    from jplephem.daf import DAF
    found = {}
    with open(file, "rb") as stream:
        daf = DAF(stream)
        for _, values in daf.summaries():
            _, _, instrument, _, kind, rates, begin, end = values
            assert (kind, rates) == (3, 0)
            words = np.array(daf.read_array(begin, end))
            intervals, records = int(words[-2]), int(words[-1])
            quaternions, at = words[:4 * records].reshape(-1, 4), 4 * records
            ticks = words[at:at + records]
            at += records + (records - 1) // 100
            found[int(instrument)] = (ticks, quaternions, words[at:at + intervals])
    return found


# verifies: GND-06
def test_a_c_kernel_read_by_another_library_has_nanoseconds_and_attitudes(run, motion):
    call(run, "--format", "ck")
    found = ck_records(run / "motion.bc")
    assert set(found) == {-999001, -999002}
    begin_ns = stamp(0) // NS * NS - NS
    for target, instrument in ((1, -999001), (2, -999002)):
        ticks, quaternions, starts = found[instrument]
        runs = [(first, last) for first, last in RUNS if target_of(first) == target]
        # The ends of each interval are held for a microsecond.
        frames = [frame for first, last in runs for frame in (first, *range(first, last + 1), last)]
        held = [shift for first, last in runs for shift in (-1000, *[0] * (last - first + 1), 1000)]
        assert ticks.astype(np.int64).tolist() == [stamp(frame) - begin_ns + shift for frame, shift in zip(frames, held)]
        assert starts.tolist() == [stamp(first) - begin_ns - 1000 for first, _ in runs]
        assert quaternion_error_rad(quaternions * [1, -1, -1, -1], motion.q_CT[frames]) < ATTITUDE_MAX_RAD


LOOK = """
import json, sys
import spiceypy
stem, dates, names = sys.argv[1], json.loads(sys.argv[2]), json.loads(sys.argv[3])
for suffix in (".tls", ".tsc", ".tf", ".bc"):
    spiceypy.furnsh(stem + suffix)
found = []
for date, name in zip(dates, names):
    try:
        matrix, _ = spiceypy.sxform("CAMERA", name, spiceypy.str2et(date)), None
        rotation, rate = spiceypy.xf2rav(matrix)
        found.append([rotation.tolist(), rate.tolist()])
    except spiceypy.exceptions.SpiceyError:
        found.append(None)
print(json.dumps(found))
"""


# verifies: GND-06
def test_spice_finds_attitudes_and_rates_by_date_and_nothing_in_gaps(run, motion, tmp_path):
    import json
    call(run, "--format", "ck", "--rates", "--out", tmp_path / "k.bc")
    gaps = [(7, 11), (15, 16), (MISSING - 1, MISSING)]
    times = [stamp(frame) for frame in POSES] + [(stamp(a) + stamp(b)) // 2 for a, b in gaps]
    dates = [str(np.datetime64(time_ns, "ns")) for time_ns in times]
    names = [f"SC_BODY_{target_of(frame)}" for frame in POSES + [a for a, _ in gaps]]
    done = subprocess.run([sys.executable, "-c", LOOK, tmp_path / "k", json.dumps(dates), json.dumps(names)], capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert found[len(POSES):] == [None] * len(gaps)
    from scipy.spatial.transform import Rotation
    for (rotation, rate), frame in zip(found, POSES):
        R_CT = Rotation.from_quat(motion.q_CT[frame], scalar_first=True)
        # A date is a float of seconds since 2000 here: 0.1 us, in which the body turns by 4e-9 rad.
        assert (Rotation.from_matrix(rotation) * R_CT).magnitude() < 1e-8
        assert np.allclose(rate, R_CT.apply(motion.w_T[frame]), rtol=0, atol=1e-8)


def bag_messages(folder) -> dict[str, list]:
    """{topic: [(log time, message)]} by mcap's own decoder of ROS 2."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory
    found = {}
    with open(next(folder.glob("*.mcap")), "rb") as stream:
        for _, channel, message, decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


# verifies: GND-06
def test_a_ros_bag_read_by_another_library_has_poses_transforms_and_cloud(run, motion):
    call(run, "--format", "rosbag2")
    found = bag_messages(run / "motion_rosbag2")
    assert set(found) == {f"/target/{kind}/{what}" for kind in ("causal", "smoothed") for what in ("pose", "angular_velocity")} | {"/tf", "/target/cloud"}
    causal = found["/target/causal/pose"]
    assert len(causal) == len(POSES)
    read = []
    for (log_ns, message), frame in zip(causal, POSES):
        pose, unit = message.pose.pose, "" if frame >= SCALED else "_map_units_1"
        assert log_ns == message.header.stamp.sec * NS + message.header.stamp.nanosec == stamp(frame)
        assert message.header.frame_id == f"camera_optical_frame{unit}"
        assert [pose.position.x, pose.position.y, pose.position.z] == motion.p_CT[frame].tolist()
        assert np.allclose(np.reshape(message.pose.covariance, (6, 6)), np.diag([0.02**2] * 3 + [0.01**2] * 3), rtol=1e-12)
        read.append([pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z])
    assert quaternion_error_rad(np.array(read), motion.q_CT[POSES]) < ATTITUDE_MAX_RAD
    transforms = [message.transforms[0] for _, message in found["/tf"]]
    assert {one.child_frame_id for one in transforms} == {"target_1_map_units_1", "target_1", "target_2", "target_1_smoothed"}
    w = found["/target/causal/angular_velocity"][5][1]
    assert w.header.frame_id == "target_1" and [w.vector.x, w.vector.y, w.vector.z] == motion.w_T[POSES[5]].tolist()
    cloud = found["/target/cloud"][0][1]
    assert (cloud.header.frame_id, cloud.width, cloud.point_step) == ("target_1_smoothed", 50, 25)


def write_as_table(folder, packets) -> None:
    """motion.csv of motion packets, as a replay writes it."""
    folder.mkdir()
    with open(folder / "motion.csv", "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow([*MOTION_HEADER, "scale_number"])
        for one in packets:
            values = [*(one.q_CT or [""] * 4), *(one.p_CT or [""] * 3), *(one.v_C or [""] * 3), *(one.w_T_rad_s or [""] * 3),
                      *(("" if x is None else x) for x in (one.sigma_att_rad, one.sigma_pos, one.sigma_vel, one.sigma_rate_rad_s))]
            texts = [f"{x:.10g}" if x != "" else "" for x in values]
            writer.writerow([one.frame, one.timestamp_ns, one.mode, *map(int, (one.pose_valid, one.rate_valid, one.velocity_valid, one.scale_known)), *texts,
                             0, 0, 0, 0, 0, "", *((1, one.scale_number) if one.pose_valid else ("", ""))])


@pytest.fixture(scope="module")
def packets():
    from polhode_bus import open_bus
    with open_bus(f"file:{GOLDEN}") as bus:
        return [packet for packet in bus.packets() if packet.name == "motion"]


# verifies: GND-06
@pytest.mark.parametrize("with_table", [False, True])
def test_covariances_are_those_of_the_packets_with_and_without_motion_csv(packets, tmp_path, with_table):
    """A live run has its packets alone."""
    folder = tmp_path / "run"
    write_as_table(folder, packets) if with_table else folder.mkdir()
    shutil.copy(GOLDEN, folder / "bus.ccsds")
    call(folder, "--format", "rosbag2")
    posed = [one for one in packets if one.pose_valid and one.mode != "COASTING"]
    poses = bag_messages(folder / "motion_rosbag2")["/target/causal/pose"]
    assert len(posed) == len(poses) > 20
    for (_, message), packet in zip(poses, posed):
        covariance = np.reshape(message.pose.covariance, (6, 6))
        # Position first; the packet has the upper triangle of (phi, dp).
        assert covariance[3, 4] == packet.cov_pose[1] and covariance[3, 0] == covariance[0, 3] == packet.cov_pose[3] and covariance[0, 0] == packet.cov_pose[15]
        assert np.isclose(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1]), packet.sigma_pos, rtol=1e-4)
        assert np.isclose(np.sqrt(np.linalg.eigvalsh(covariance[3:, 3:])[-1]), packet.sigma_att_rad, rtol=1e-4)


def test_packets_of_another_run_give_no_covariances(run, capsys):
    shutil.copy(GOLDEN, run / "bus.ccsds")
    call(run, "--format", "oem")
    assert "bus.ccsds is not of these poses" in capsys.readouterr().err


def test_smoothed_poses_have_a_frame_of_their_own(run):
    call(run, "--format", "aem", "--smoothed")
    text = (run / "motion_smoothed.aem").read_text()
    assert "= SC_BODY_101" in text and text.count("META_START") == 2  # around the missing frames


def test_a_longer_gap_may_be_allowed(run):
    call(run, "--format", "aem", "--smoothed", "--gap-s", 2)
    assert (run / "motion_smoothed.aem").read_text().count("META_START") == 1


def without_scale(run) -> None:
    header, *rows = csv.reader((run / "motion.csv").read_text().splitlines())
    for row in rows:
        row[header.index("scale_known")], row[-1] = "0", row[-1] and "1"
    (run / "motion.csv").write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")


def test_map_units_become_km_only_by_a_stated_scale(run, motion, capsys):
    without_scale(run)
    with pytest.raises(BadInput, match=r"in map units, and an OEM is in km; give the replay a known length .* --metres-per-unit"):
        call(run, "--format", "oem")
    assert not (run / "motion.oem").exists()
    call(run, "--format", "oem", "--metres-per-unit", 2)
    first = next(line.split() for line in (run / "motion.oem").read_text().splitlines() if re.match(r"\d{4}-", line))
    assert np.allclose([float(value) for value in first[1:4]], 2 * KM * motion.p_CT[POSES[0]], rtol=1e-12)
    assert "metres by --metres-per-unit 2" in capsys.readouterr().err
    with pytest.raises(BadInput, match="are in metres already"):
        call(run, "--format", "oem", "--smoothed", "--metres-per-unit", 2)


def test_a_clock_that_nobody_set_is_told_and_has_no_leap_seconds(run, capsys):
    text = (run / "motion.csv").read_text()
    (run / "motion.csv").write_text(text.replace(",17000000", ",00000000"))
    call(run, "--format", "aem")
    assert "that clock was not set to the date" in capsys.readouterr().err
    with pytest.raises(BadInput, match="allowed is --clock tai"):
        call(run, "--format", "ck")
    call(run, "--format", "ck", "--clock", "tai")


@pytest.mark.parametrize(("arguments", "says"), [
    (["--format", "oem", "--rates"], "--rates: is for --format aem, apm, ck, not oem"),
    (["--format", "apm", "--frame", "8"], "--frame 8: has no pose in motion.csv; allowed are frames with one, from 3 to 29"),
    (["--format", "aem", "--out", "FILE"], "is there already and was not made by this command"),
    (["--format", "rosbag2", "--out", "FILE"], "is there already and is no folder"),
    (["--format", "rosbag2", "--out", "FOLDER"], "holds files that this command did not write \\(mine\\)"),
    (["--format", "ck", "--out", "other.tf"], "a C-kernel's name ends in .bc"),
    (["--format", "ck", "--out", "k.bc"], "k.tf: is there already and was not made by this command"),
])
def test_what_cannot_be_done_is_refused_and_leaves_all_as_it_was(run, tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FOLDER").mkdir()
    for name in ("FILE", "FOLDER/mine", "k.tf"):
        (tmp_path / name).write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(BadInput, match=says):
        call(run, *arguments)
    assert sorted(tmp_path.rglob("*")) == before and (tmp_path / "k.tf").read_text() == "mine"


def test_what_it_wrote_is_replaced(run):
    for kind in ("aem", "ck", "rosbag2"):
        call(run, "--format", kind)
        call(run, "--format", kind)
    assert sorted(file.name for file in (run / "motion_rosbag2").iterdir()) == [".polhode-export", "metadata.yaml", "motion_rosbag2.mcap"]


def test_rates_are_refused_where_the_servicer_reported_that_it_turns(run):
    """Housekeeping has the flag."""
    from polhode_bus.decode import crc16
    from polhode_bus.packets import APID_FIRST, LAYOUT_VERSION, PACKETS
    number, (_, octets, flags, rows, _) = next((key, row) for key, row in PACKETS.items() if row[0] == "housekeeping")
    packet = bytearray(octets)
    struct.pack_into(">HHH", packet, 0, 0x0800 | (APID_FIRST + number), 0xC000, octets - 7)
    packet[6], packet[14] = 0x2F, LAYOUT_VERSION
    packet[next(row[3] for row in rows if row[0] == "flags")] = 1 << flags.index("servicer_attitude")
    struct.pack_into(">H", packet, octets - 2, crc16(bytes(packet[:-2])))
    (run / "bus.ccsds").write_bytes(bytes(packet))
    with pytest.raises(BadInput, match="the servicer reported its attitude"):
        call(run, "--format", "aem", "--rates")


def test_a_run_that_never_acquired_has_nothing_to_export(run):
    header, *rows = (run / "motion.csv").read_text().splitlines()
    (run / "motion.csv").write_text("\n".join([header, *rows[:3]]) + "\n")
    with pytest.raises(BadInput, match="none of 3 frames has a pose"):
        call(run, "--format", "aem")
