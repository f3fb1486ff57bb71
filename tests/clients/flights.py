"""The sample's first frames replayed with commands, and its stream damaged: fixtures for clients of the bus."""

import csv
import os
import pathlib
import shutil
import subprocess
import types

import numpy
import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
CLIENT = REPOSITORY / "platform/transport/client"
XTCE = REPOSITORY / "config/bus/polhode.xtce.xml"
FRAMES = 24
KINDS = ["motion", "model", "prediction", "shape", "housekeeping", "event", "cloud"]  # that a replay sends

COMMANDS = """\
{0} noop
{2} set_range range_m=8.0 frame_timestamp_ns={8}
{9} servicer_attitude timestamp_ns={9} q_IC=1,0,0,0 w_C_rad_s=0,0,0
{10} table_load bus.housekeeping_every_frames=5 features.sigma_px=0.26
{11} table_activate
{12} hex 19AFC0000003030000FF   # its checksum is wrong
{13} request_cloud points_max=300
{14} table_load features.count_max=5000
{15} checkpoint
"""


def first_frames(sequence: pathlib.Path, folder: pathlib.Path, count: int) -> list[int]:
    """The first frames of a sequence as one of their own. @return their time stamps."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    shutil.copy(sequence / "mav0/cam0/sensor.yaml", camera)
    (camera / "data").symlink_to(sequence / "mav0/cam0/data")
    lines = (sequence / "mav0/cam0/data.csv").read_text().splitlines()[:count + 1]
    (camera / "data.csv").write_text("\n".join(lines) + "\n")
    return [int(line.split(",")[0]) for line in lines[1:]]


@pytest.fixture(scope="session")
def flight(tmp_path_factory):
    """The sample's first frames replayed with commands: stream (bytes), file, rows of motion.csv, packets by the Python client."""
    from polhode_bus import open_bus

    folder = tmp_path_factory.mktemp("flight")
    stamps = first_frames(REPOSITORY / "hil/data/sample", folder / "sequence", FRAMES)
    (folder / "commands.txt").write_text(COMMANDS.format(*stamps))
    done = subprocess.run([PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", folder / "sequence",
                           "--out", folder / "out", "--commands", folder / "commands.txt"], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    file = folder / "out/bus.ccsds"
    with open(folder / "out/motion.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    with open_bus(f"file:{file}") as bus:
        packets = list(bus.packets())
        assert bus.missing == bus.damaged == 0
    return types.SimpleNamespace(folder=folder, file=file, stream=file.read_bytes(), rows=rows, packets=packets)


@pytest.fixture(scope="session")
def damaged(flight):
    """The stream with one octet changed in the fifth motion packet, and one packet taken out. @return stream, index of the packets."""
    packets = split(flight.stream)
    motion = [index for index, packet in enumerate(packets) if packet[:2] == packets[0][:2]]
    bad, gone = motion[4], motion[8]
    changed = bytearray(packets[bad])
    changed[100] ^= 0x40
    out = [bytes(changed) if index == bad else packet for index, packet in enumerate(packets) if index != gone]
    return types.SimpleNamespace(stream=b"".join(out), packets=out, bad=4, gone=8)


def split(stream: bytes) -> list[bytes]:
    packets, at = [], 0
    while at < len(stream):
        octets = int.from_bytes(stream[at + 4:at + 6], "big") + 7
        packets.append(stream[at:at + octets])
        at += octets
    return packets


def compared_columns() -> dict[str, tuple[str, str]]:
    """Field of the motion packet, flat -> column of motion.csv, the flag that it goes with."""
    columns = {f"q_CT_{axis}": (f"q_CT_{axis}", "pose_valid") for axis in "wxyz"}
    columns.update({f"p_CT_{axis}": (f"p_CT_{axis}", "pose_valid") for axis in "xyz"})
    columns.update({f"v_C_{axis}": (f"v_C_{axis}", "velocity_valid") for axis in "xyz"})
    columns.update({f"w_T_rad_s_{axis}": (f"w_T_{axis}", "rate_valid") for axis in "xyz"})
    columns.update({name: (name, flag) for name, flag in
                    (("sigma_att_rad", "pose_valid"), ("sigma_pos", "pose_valid"), ("sigma_vel", "velocity_valid"),
                     ("sigma_rate_rad_s", "rate_valid"))})
    return columns


def expect_rows(found: list[dict], rows: list[dict]) -> None:
    """`found`: flat fields of the motion packets in order."""
    assert len(found) == len(rows)
    for values, row in zip(found, rows):
        assert int(values["frame"]) == int(row["frame"]) and int(values["timestamp_ns"]) == int(row["timestamp_ns"])
        assert row["pose_valid"] == "0" or int(values["scale_number"]) == int(row["scale_number"]) % 16
        for field, (column, flag) in compared_columns().items():
            if row[flag] == "1":
                assert float(values[field]) == pytest.approx(float(row[column]), rel=1e-8, abs=1e-12), (row["frame"], field)
            else:
                assert float(values[field]) == 0.0 and row[column] == ""


def flat(packet) -> dict:
    """Values of a packet of the Python client by the flat names of XTCE and CSV; zeros where a flag is down, numbers for words."""
    from polhode_ground.busgen.table import read_table

    layout = read_table(REPOSITORY / "config/bus").packet(packet.name)
    values = {}
    for field in layout.fields:
        if field.is_flags and layout.flags_number:
            values[layout.flags_number] = packet.values[layout.flags_number]
        if field.is_flags or field.name == "spare":
            continue
        value = packet.values[field.name]
        listed = numpy.ravel(value).tolist() if field.is_array and field.type != "text" else [value]
        if value is None:
            listed = [0] * len(field.element_names())
        if field.enum:
            listed = [field.enum.index(word) if isinstance(word, str) else word for word in listed]
        values.update(zip(field.element_names(), listed))
    return values
