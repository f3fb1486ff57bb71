"""What a commanded replay puts on the bus."""

import itertools
import subprocess

from flights import FRAMES, PROGRAM, REPOSITORY


def named(flight, name):
    return [packet for packet in flight.packets if packet.name == name]


def events(flight, name):
    from polhode_bus.packets import EVENTS

    return [packet for packet in named(flight, "event") if EVENTS[packet.id][0] == name]


def test_one_motion_packet_a_frame(flight):
    assert [packet.frame for packet in named(flight, "motion")] == list(range(FRAMES))


# verifies: BUS-05
def test_counts_are_without_gaps_for_every_apid(flight):
    for _, group in itertools.groupby(sorted(flight.packets, key=lambda p: p.name), key=lambda p: p.name):
        counts = [packet.header.sequence for packet in group]
        assert counts == list(range(len(counts)))


def test_commands_are_answered(flight):
    assert events(flight, "noop")[0].text.startswith("NOOP, version ")
    assert len(events(flight, "command_crc")) == 1
    assert len(events(flight, "table_activated")) == 1
    assert events(flight, "table_refused")[0].text == "table entry 0 refused: features.count_max"
    assert len(events(flight, "checkpoint_asked")) == 1
    last = named(flight, "housekeeping")[-1]
    assert (last.commands_accepted, last.commands_rejected) == (7, 2)
    assert last.servicer_attitude and last.memory_octets > 1e6 and last.packets_not_sent == 0


def test_an_activated_parameter_takes_effect_with_the_next_frame(flight):
    frames = [packet.frame for packet in named(flight, "housekeeping")]
    assert frames == [0, 10, 15, 20]  # every 10 frames, from the 12th frame on every 5


def test_shape_model_and_predictions_are_told(flight):
    shape = named(flight, "shape")[-1]
    assert shape.shape_valid and shape.plane_count > 0 and all(length > 0.0 for length in shape.dimensions)
    assert shape.frame_of_estimate <= shape.frame
    models = named(flight, "model")
    assert models[-1].dynamics == "TORQUE_FREE" and models[-1].rate_valid and models[-1].w_T_rad_s is not None
    ahead = sorted({(p.predicted_timestamp_ns - p.timestamp_ns) // 10**9 for p in named(flight, "prediction")})
    assert ahead[0] == 10 and set(ahead) <= {10, 30, 60, 120, 300, 600, 900, 1200, 1800} and len(ahead) > 1


# verifies: CMD-01
def test_every_accepted_command_is_answered_by_an_event(flight):
    assert len(events(flight, "command_accepted")) == named(flight, "housekeeping")[-1].commands_accepted - 1  # NOOP by its own


def test_a_requested_cloud_comes_whole(flight):
    chunks = named(flight, "cloud")
    assert [chunk.chunk for chunk in chunks] == list(range(chunks[0].chunks))
    assert sum(chunk.points for chunk in chunks) == chunks[0].points_total <= 300
    points = [point for chunk in chunks for point in chunk.p_T[:chunk.points]]
    assert len(set(map(tuple, points))) > 0.9 * len(points)


def test_events_tell_of_the_start_and_of_the_target(flight):
    assert events(flight, "started")[0].frame == 0
    assert len(events(flight, "target_acquired")) == 1
    assert all(len(packet.text) == packet.text_octets <= 122 for packet in named(flight, "event"))


def test_commands_are_part_of_what_determines_the_bytes(flight, tmp_path):
    arguments = [PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", flight.folder / "sequence"]
    subprocess.run([*arguments, "--out", tmp_path / "same", "--set", f"commands.file='{flight.folder / 'commands.txt'}'"],
                   check=True, capture_output=True, timeout=900)
    assert (tmp_path / "same/bus.ccsds").read_bytes() == flight.stream


def test_dump_tells_of_packets_that_are_none_of_the_field_table_once(flight, tmp_path):
    (tmp_path / "bus.ccsds").write_bytes(flight.stream)
    done = subprocess.run([PROGRAM, "bus", "dump", "--apid-first", "700", tmp_path / "bus.ccsds"], capture_output=True, text=True)
    lines = done.stderr.splitlines()
    assert done.returncode == 0 and len(lines) == len({packet.header.apid for packet in flight.packets}) + 1
    assert "packets of APID 416, which is none of 700 and following (--apid-first)" in lines[0]


def test_dump_tells_of_damage_and_reads_on(damaged, tmp_path):
    (tmp_path / "damaged.ccsds").write_bytes(damaged.stream)
    done = subprocess.run([PROGRAM, "bus", "dump", tmp_path / "damaged.ccsds"], capture_output=True, text=True)
    assert done.returncode == 0
    assert "310 octets at offset" in done.stderr
    assert f"{len(damaged.packets) - 1} packets, 2 missing by their counts, 310 octets damaged" in done.stderr
