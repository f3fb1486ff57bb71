"""Recordings of other tools: MCAP in each encoding, cut or without an index, bags that their recorder left unfinished, video in messages."""

import base64
import fractions
import json

import made_sources as sources
import numpy as np
import pytest
from made_sources import NS
from PIL import Image

START = 1_700_000_000 * NS
STEP = NS // 10
COUNT = 4


@pytest.fixture(scope="module")
def pictures():
    """Four, each of another brightness."""
    ramp = np.add.outer(np.arange(48), np.arange(64)).astype(np.uint8)
    return [ramp + np.uint8(20 * index) for index in range(COUNT)]


def opened(path, **options):
    """(pixels by time, the source) of all that is read."""
    from polhode_ground.importing.recognise import open_source
    from polhode_ground.importing.source import Options
    source = open_source(path, Options(**options))
    return {frame.timestamp_ns: frame.pixels for frame in source.frames}, source


def png(pixels) -> bytes:
    import cv2
    return cv2.imencode(".png", pixels)[1].tobytes()


def is_whole(found, pictures) -> bool:
    return list(found) == [START + index * STEP for index in range(len(pictures))] and all(map(np.array_equal, found.values(), pictures))


def write_protobuf(path, messages, topic="/camera/image"):
    from mcap_protobuf.writer import Writer
    with open(path, "wb") as file, Writer(file) as writer:
        for index, message in enumerate(messages):
            time_ns = START + index * STEP
            message.timestamp.FromNanoseconds(time_ns)
            writer.write_message(topic, message, log_time=time_ns + 5, publish_time=time_ns)
    return path


def foxglove_message(kind, **fields):
    import importlib
    return getattr(importlib.import_module(f"foxglove_schemas_protobuf.{kind}_pb2"), kind)(**fields)


def write_mcap(path, schema, encoding, payloads, **options):
    """@param schema  (name, encoding, text)"""
    from mcap.writer import Writer
    with open(path, "wb") as file:
        writer = Writer(file, **options)
        writer.start()
        channel = writer.register_channel("/camera/image", encoding, writer.register_schema(schema[0], schema[1], schema[2].encode()))
        for index, payload in enumerate(payloads):
            writer.add_message(channel, START + index * STEP + 5, payload, START + index * STEP)
        writer.finish()
    return path


def json_payloads(pictures, stamp="nsec"):
    times = [START + index * STEP for index in range(len(pictures))]
    return [json.dumps({"timestamp": {"sec": time // NS, stamp: time % NS}, "format": "png", "data": base64.b64encode(png(one)).decode()}).encode()
            for time, one in zip(times, pictures)]


# verifies: GND-03
@pytest.mark.parametrize("kind", ["RawImage", "CompressedImage"])
def test_protobuf(pictures, tmp_path, kind):
    if kind == "RawImage":
        messages = [foxglove_message(kind, width=64, height=48, encoding="mono8", step=64, data=one.tobytes()) for one in pictures]
    else:
        messages = [foxglove_message(kind, format="png", data=png(one)) for one in pictures]
    found, source = opened(write_protobuf(tmp_path / "a.mcap", messages))
    assert is_whole(found, pictures) and source.kind == f"bag, topic /camera/image (foxglove.{kind}), 4 pictures"


def test_the_calibration_of_foxglove_is_taken(pictures, tmp_path):
    from mcap_protobuf.writer import Writer
    path = tmp_path / "a.mcap"
    with open(path, "wb") as file, Writer(file) as writer:
        message = foxglove_message("CompressedImage", format="png", data=png(pictures[0]))
        message.timestamp.FromNanoseconds(START)
        writer.write_message("/camera/image", message, log_time=START + 5)
        writer.write_message("/camera/calibration", foxglove_message("CameraCalibration", width=64, height=48, distortion_model="plumb_bob",
                                                                     K=[50, 0, 31, 0, 51, 23, 0, 0, 1], D=[0.1, 0, 0, 0, 0]), log_time=START)
    found, source = opened(path)
    assert list(found) == [START]
    assert source.lens.intrinsics_px == (50, 51, 31, 23) and source.lens.coefficients[0] == 0.1 and source.lens_from == "/camera/calibration"


@pytest.mark.parametrize("stamp", ["nsec", "nanosec"])
def test_json(pictures, tmp_path, stamp):
    path = write_mcap(tmp_path / "a.mcap", ("foxglove.CompressedImage", "jsonschema", "{}"), "json", json_payloads(pictures, stamp))
    assert is_whole(opened(path)[0], pictures)


@pytest.mark.parametrize("version", [1, 2])
def test_messages_of_ros_in_a_file_of_no_profile(pictures, tmp_path, version):
    store = sources.ros_types(version)
    name = "sensor_msgs/msg/Image" if version == 2 else "sensor_msgs/Image"
    text = store.generate_msgdef("sensor_msgs/msg/Image", ros_version=version)[0]
    serialise = store.serialize_cdr if version == 2 else store.serialize_ros1
    payloads = [bytes(serialise(sources.image_message(store, one, START + i * STEP), "sensor_msgs/msg/Image")) for i, one in enumerate(pictures)]
    path = write_mcap(tmp_path / "a.mcap", (name, f"ros{version}msg", text), "cdr" if version == 2 else "ros1", payloads)
    assert is_whole(opened(path)[0], pictures)


def test_an_encoding_that_is_not_known_is_named(tmp_path):
    from polhode_ground.common.errors import BadInput
    path = write_mcap(tmp_path / "a.mcap", ("foxglove.RawImage", "flatbuffer", ""), "flatbuffer", [b"?"])
    with pytest.raises(BadInput, match=r"topic /camera/image \(foxglove.RawImage\) in 'flatbuffer'.*allowed are CDR, ROS 1, Protobuf and JSON"):
        opened(path)


def test_what_a_cut_or_spoilt_mcap_holds_is_read_and_the_loss_told(pictures, tmp_path):
    from mcap.writer import CompressionType
    whole = write_mcap(tmp_path / "a.mcap", ("foxglove.CompressedImage", "jsonschema", "{}"), "json", json_payloads(pictures), chunk_size=1,
                       compression=CompressionType.ZSTD)
    octets = whole.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(octets[:len(octets) // 3])
    found, source = opened(tmp_path / "cut.mcap")
    assert 0 < len(found) < COUNT and np.array_equal(found[START], pictures[0])
    assert "the recording is damaged: no index at its end" in " ".join(source.account.assumed)
    assert f"cut or damaged from octet {len(octets) // 3} of {len(octets) // 3} on" in " ".join(source.account.assumed)
    spoilt = bytearray(octets)
    place = octets.index(b"zstd") + 40
    spoilt[place:place + 20] = b"\xff" * 20
    (tmp_path / "spoilt.mcap").write_bytes(spoilt)
    found, source = opened(tmp_path / "spoilt.mcap")
    assert list(found) == [START + index * STEP for index in range(1, COUNT)]
    assert source.account.dropped == {"missing in the recording, whose index promises them": 1}
    assert "1 chunks can't be unpacked" in " ".join(source.account.assumed)


def test_an_mcap_without_a_summary_is_read(pictures, tmp_path):
    from mcap.writer import IndexType
    path = write_mcap(tmp_path / "a.mcap", ("foxglove.CompressedImage", "jsonschema", "{}"), "json", json_payloads(pictures), use_chunking=False,
                      use_summary_offsets=False, use_statistics=False, repeat_channels=False, repeat_schemas=False, index_types=IndexType.NONE)
    found, source = opened(path)
    assert is_whole(found, pictures) and not source.account.dropped


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_bag_that_was_not_closed_has_no_metadata(pictures, tmp_path, storage):
    store = sources.ros_types(2)
    messages = [("/cam/image", START + i, sources.image_message(store, one, START + i * STEP)) for i, one in enumerate(pictures)]
    sources.write_bag(tmp_path / "bag", 2, messages, storage)
    (tmp_path / "bag/metadata.yaml").unlink()
    assert is_whole(opened(tmp_path / "bag")[0], pictures)
    assert is_whole(opened(next((tmp_path / "bag").iterdir()))[0], pictures)
    (tmp_path / "bag/metadata.yaml").write_text("rosbag2_bagfile_information: {version")
    assert is_whole(opened(tmp_path / "bag")[0], pictures)


@pytest.mark.parametrize("keep_end", [True, False])
def test_a_spoilt_bag_of_sqlite_is_read_from_both_ends(tmp_path, keep_end):
    store, noise = sources.ros_types(2), np.random.default_rng(1).integers(0, 255, (48, 64), np.uint8)
    sources.write_bag(tmp_path / "bag", 2, [("/cam/image", START + i, sources.image_message(store, noise, START + i * STEP)) for i in range(40)])
    file = next((tmp_path / "bag").glob("*.db3"))
    octets = bytearray(file.read_bytes())
    middle = len(octets) // 8192 * 4096  # pages are of 4096 octets
    octets[middle:middle + 8192] = bytes(8192)
    file.write_bytes(octets if keep_end else octets[:middle + 8192])
    found, source = opened(tmp_path / "bag")
    said = " ".join(source.account.assumed)
    numbers = [(time - START) // STEP for time in found]
    assert 10 < len(numbers) < 40 and numbers == sorted(numbers) and all(np.array_equal(one, noise) for one in found.values())
    assert (numbers[-1] == 39) == keep_end
    assert "the recording is damaged" in said and "can't be read" in said


def test_a_topic_without_messages_is_no_choice(pictures, tmp_path):
    store = sources.ros_types(2)
    from rosbags.rosbag2 import StoragePlugin, Writer
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        writer.add_connection("/empty", "sensor_msgs/msg/Image", typestore=store)
        connection = writer.add_connection("/full", "sensor_msgs/msg/Image", typestore=store)
        for index, one in enumerate(pictures):
            writer.write(connection, START, store.serialize_cdr(sources.image_message(store, one, START + index * STEP), "sensor_msgs/msg/Image"))
    found, source = opened(tmp_path / "bag")
    assert is_whole(found, pictures) and "/full" in source.kind


ENCODED = [("libx264", "h264", {"tune": "zerolatency", "crf": "4", "sc_threshold": "0"}),
           ("libx265", "h265", {"tune": "zerolatency", "crf": "4", "x265-params": "log-level=none"}),
           ("libvpx-vp9", "vp9", {"deadline": "realtime", "lag-in-frames": "0", "crf": "4"})]


def encoded(pictures, encoder, options) -> list[bytes]:
    """One packet a picture; all of one group, whose parameters stand before its key frame."""
    import av
    context = av.CodecContext.create(encoder, "w")
    context.width, context.height, context.pix_fmt, context.options, context.gop_size = 64, 48, "yuv420p", options, 4
    context.time_base = fractions.Fraction(1, 10)
    packets = []
    for one in [*[av.VideoFrame.from_ndarray(pixels, format="gray").reformat(format="yuv420p") for pixels in pictures], None]:
        packets += [bytes(packet) for packet in context.encode(one)]
    return packets


# verifies: GND-03
@pytest.mark.parametrize(("encoder", "name", "options"), ENCODED)
def test_video_in_messages(pictures, tmp_path, encoder, name, options):
    packets = encoded(pictures, encoder, options)
    found, _ = opened(write_protobuf(tmp_path / "a.mcap", [foxglove_message("CompressedVideo", format=name, data=one) for one in packets]))
    assert list(found) == [START + index * STEP for index in range(COUNT)]
    assert all(np.abs(found[time].astype(int) - one).mean() < 3 for time, one in zip(found, pictures))


def test_video_in_messages_of_ros_goes_on_after_damage(pictures, tmp_path):
    from polhode_ground.importing.mcap_file import ros_store
    store = ros_store()
    Video, Time = store.types["foxglove_msgs/msg/CompressedVideo"], store.types["builtin_interfaces/msg/Time"]
    packets = encoded(pictures * 3, *ENCODED[0][::2])  # a key frame every four
    packets[5] = b"\xff" * len(packets[5])
    times = [START + index * STEP for index in range(len(packets))]
    sources.write_messages(tmp_path / "bag", store, [
        ("/cam", time, Video(Time(time // NS, time % NS), "", np.frombuffer(one, np.uint8), "h264")) for time, one in zip(times, packets)])
    found, source = opened(tmp_path / "bag")
    assert list(found) == [*times[:5], *times[8:]]
    assert source.account.dropped == {"damaged, or built on a damaged frame": 3}
    assert any("damage at 0.500 s" in said and "next key frame at 0.800 s" in said for said in source.account.assumed)


@pytest.mark.parametrize("name", ["nv12", "nv21", "NV12", "i420", "yv12"])
@pytest.mark.parametrize("rows", [48, 72])  # some drivers count those of the colour
def test_planes_of_colour_are_left_out(pictures, name, rows):
    from polhode_ground.importing.bag import raw_pixels
    message = sources.image_message(sources.ros_types(2), np.vstack([pictures[0], np.full((24, 64), 128, np.uint8)]), 0, name, padding=8)
    message.height = rows
    assert np.array_equal(raw_pixels(message, "bag"), pictures[0])


def test_octets_in_the_order_of_the_message(pictures):
    from polhode_ground.importing.bag import raw_pixels
    deep = pictures[0].astype(np.uint16) * 257 + 3
    message = sources.image_message(sources.ros_types(2), deep.astype(">u2"), 0, "mono16")
    message.is_bigendian = 1
    assert np.array_equal(raw_pixels(message, "bag"), deep)


def test_distances_are_no_pictures(pictures, tmp_path):
    from polhode_ground.common.errors import BadInput
    store = sources.ros_types(2)
    message = sources.compressed_message(store, png(pictures[0]), START)
    message.format = "16UC1; compressedDepth png"
    sources.write_bag(tmp_path / "bag", 2, [("/depth", START, message)])
    with pytest.raises(BadInput, match="holds distances, allowed are pictures of light"):
        opened(tmp_path / "bag")


def test_a_mosaic_in_a_png_is_made_a_picture(tmp_path):
    store, red_only = sources.ros_types(2), np.zeros((8, 8), np.uint8)
    red_only[::2, ::2] = 200
    message = sources.compressed_message(store, png(red_only), START)
    message.format = "bayer_rggb8; png compressed "
    sources.write_bag(tmp_path / "bag", 2, [("/cam", START, message)])
    found, _ = opened(tmp_path / "bag")
    assert np.abs(found[START][2:-2, 2:-2].astype(float) - 0.299 * 200).max() <= 2


def test_a_webp_in_a_message_is_read(pictures, tmp_path):
    import io
    stream = io.BytesIO()
    Image.fromarray(pictures[0]).save(stream, "WEBP", lossless=True)
    found, _ = opened(write_protobuf(tmp_path / "a.mcap", [foxglove_message("CompressedImage", format="webp", data=stream.getvalue())]))
    assert np.abs(found[START].astype(int) - pictures[0]).max() <= 1
