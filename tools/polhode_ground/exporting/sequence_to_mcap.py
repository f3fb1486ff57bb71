"""Puts a sequence, the packets that belong to it and what a replay found into one MCAP file, as Foxglove reads it.

SEQ is a sequence as `polhode recording export` or tools/import_sequence.py write it.
  /camera/image        foxglove.CompressedImage (JSON), at their time of mid-exposure: JPEG files and PNG files of 8 bits as
                       they are; others, which viewers do not show, as PNG of 8 bits as bright as the replay sees them
  /bus/packet          the packets as they were published, one a message, at their own time
With --run also, as Protobuf:
  /camera/calibration  foxglove.CameraCalibration
  /target/causal, /target/smoothed
                       foxglove.FrameTransform: T to C for each row with a pose of motion.csv and of motion_smoothed.csv
                       (its last frame T); lengths as those files have them
  /target/cloud        foxglove.PointCloud: cloud.ply with its sigma, views and added
  /target/events       foxglove.Log: the event packets as text
Parameters, camera and the account of the recording are attachments.

Examples:
  tools/sequence_to_mcap.py SEQ --out run.mcap --run DIR
  tools/sequence_to_mcap.py SEQ --out run.mcap --bus bus.ccsds
"""

import argparse
import base64
import json
import pathlib
import sys

from polhode_ground.common.venv import enter_venv, run_main

IMAGE_SCHEMA = {
    "title": "foxglove.CompressedImage",
    "type": "object",
    "properties": {
        "timestamp": {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
        "frame_id": {"type": "string"},
        "data": {"type": "string", "contentEncoding": "base64"},
        "format": {"type": "string"},
    },
}
ATTACHMENTS = ("config.toml", "recording.json", "commands.csv", "mav0/cam0/sensor.yaml")
CUC_AT = 6  # P-field, four octets of seconds, three of their fraction (docs/bus.md)


def packets_of(bus: pathlib.Path):
    """Packet by packet, passing over what is none, as a run that was cut off leaves it."""
    from polhode_bus import open_bus

    with open_bus(f"file:{bus}") as source:
        while (packet := source.next_octets(timeout_s=0.0)) is not None:
            yield packet


def time_of(packet: bytes) -> int:
    """Nanoseconds, to the 60 ns that the field resolves."""
    whole = int.from_bytes(packet[CUC_AT + 1 : CUC_AT + 5], "big")
    fraction = int.from_bytes(packet[CUC_AT + 5 : CUC_AT + 8], "big")
    return whole * 1_000_000_000 + round(fraction * 1e9 / 2**24)


def image_of(sequence, index: int) -> tuple[bytes, str, bool]:
    """@return octets that viewers show, their format, and whether they are another picture than the file."""
    import cv2

    from polhode_ground.common.levels import read_octets, viewable

    octets = read_octets(sequence.frame_path(index))
    kind = viewable(octets)
    if kind is not None and not sequence.mosaic:
        return octets, kind, False
    return cv2.imencode(".png", sequence.read_gray(index))[1].tobytes(), "png", True


def write_images(writer, sequence) -> tuple[int, int, int]:
    """@return images; of them converted ones; files that can't be read."""
    from polhode_ground.common.errors import BadInput

    schema = writer.register_schema("foxglove.CompressedImage", "jsonschema", json.dumps(IMAGE_SCHEMA).encode())
    channel = writer.register_channel("/camera/image", "json", schema)
    count, converted, unreadable = 0, 0, 0
    for index, stamp in enumerate(sequence.timestamp_ns.tolist()):
        if not sequence.frame_path(index).exists():
            continue  # a frame that the camera could not deliver whole
        try:
            octets, kind, other = image_of(sequence, index)
        except BadInput:
            unreadable += 1
            continue
        converted += other
        message = {
            "timestamp": {"sec": stamp // 1_000_000_000, "nsec": stamp % 1_000_000_000},
            "frame_id": "C",
            "data": base64.b64encode(octets).decode(),
            "format": kind,
        }
        writer.add_message(channel, stamp, json.dumps(message).encode(), stamp, count)
        count += 1
    return count, converted, unreadable


def write_packets(writer, bus: pathlib.Path) -> tuple[int, int]:
    """@return packets, and octets that were none."""
    channel = writer.register_channel("/bus/packet", "ccsds", 0)
    count, octets = 0, 0
    for packet in packets_of(bus):
        writer.add_message(channel, time_of(packet), packet, time_of(packet), count)
        count += 1
        octets += len(packet)
    return count, bus.stat().st_size - octets


def write_run(writer, run: pathlib.Path, sequence: pathlib.Path) -> int:
    """What the replay found. @return messages."""
    from mcap_protobuf.schema import build_file_descriptor_set

    from polhode_ground.reporting.foxglove_messages import messages_of
    from polhode_ground.reporting.gather import gather

    channels, schemas, count = {}, {}, 0
    for topic, time_ns, message in messages_of(gather(run, sequence)):
        kind = message.DESCRIPTOR.full_name
        if kind not in schemas:
            schemas[kind] = writer.register_schema(kind, "protobuf", build_file_descriptor_set(type(message)).SerializeToString())
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, "protobuf", schemas[kind])
        writer.add_message(channels[topic], time_ns, message.SerializeToString(), time_ns, count)
        count += 1
    return count


def convert(
    folder: pathlib.Path, bus: pathlib.Path | None, run: pathlib.Path | None, out: pathlib.Path
) -> tuple[tuple[int, int, int], int, int, int]:
    """@return images as write_images() counts them, packets, octets among the packets that were none, messages of the run."""
    from mcap.writer import Writer

    from polhode_ground.common.sequence import read_json, read_sequence
    from polhode_ground.common.whole_file import MARK, beside

    sequence = read_sequence(folder)
    sequence.see_as(read_json(run / "summary.json") if run is not None else {})
    if bus is None and run is not None:
        bus = run / "bus.ccsds"
    with beside(out) as part, open(part, "wb") as file:
        writer = Writer(file)
        writer.start(library=f"polhode ({MARK})")
        counts = (
            write_images(writer, sequence),
            *((0, 0) if bus is None else write_packets(writer, bus)),
            0 if run is None else write_run(writer, run, folder),
        )
        for name in ATTACHMENTS:
            if (folder / name).exists():
                stamp = int(sequence.timestamp_ns[0]) if len(sequence.timestamp_ns) else 0
                writer.add_attachment(stamp, stamp, pathlib.Path(name).name, "text/plain", (folder / name).read_bytes())
        writer.finish()
    return counts


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 made; 2 SEQ, the packets or the run cannot be read (one line says which).",
    )
    parser.add_argument("sequence", type=pathlib.Path, metavar="SEQ", help="sequence folder")
    parser.add_argument("--bus", type=pathlib.Path, metavar="bus.ccsds", help="the packets (default: those of --run)")
    parser.add_argument("--run", type=pathlib.Path, metavar="DIR", help="output folder of a replay of SEQ")
    parser.add_argument("--out", type=pathlib.Path, required=True, metavar="run.mcap")
    asked = parser.parse_args()
    from polhode_ground.common.errors import BadInput

    try:
        (images, converted, unreadable), packets, damaged, found = convert(asked.sequence, asked.bus, asked.run, asked.out)
    except (BadInput, OSError) as problem:
        print(f"sequence_to_mcap: {problem}", file=sys.stderr)
        return 2
    if converted:
        print(
            f"sequence_to_mcap: {converted} images were converted to PNG of 8 bits, as bright as a replay sees them: viewers show PNG and JPEG of 8 bits only",
            file=sys.stderr,
        )
    if unreadable:
        print(f"sequence_to_mcap: {unreadable} images can't be read and were left out", file=sys.stderr)
    print(f"{images} images, {packets} packets, {found} messages of the run: {asked.out}")
    if damaged:
        print(
            f"sequence_to_mcap: {asked.bus or asked.run / 'bus.ccsds'}: {damaged} octets are no packet and were passed over",
            file=sys.stderr,
        )
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "sequence_to_mcap")
