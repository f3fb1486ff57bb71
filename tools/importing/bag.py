"""ROS 1 and 2 bags and MCAP files by `rosbags`: Image, CompressedImage, CameraInfo. MCAP with Foxglove's JSON by `mcap`."""

import base64
import contextlib
import json
import pathlib
from collections.abc import Iterator

import numpy as np
from importing.lens import Lens, lens_of
from importing.source import NS, Account, Frame, Options, Source

from judge.errors import BadInput

RAW, COMPRESSED, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo"
FOXGLOVE_IMAGE = "foxglove.CompressedImage"
SUFFIXES = (".bag", ".mcap", ".db3")
# Encodings of sensor_msgs/Image: (type, channels, OpenCV's conversion to gray or None).
ENCODINGS = {
    "mono8": ("u1", 1, None), "8UC1": ("u1", 1, None), "mono16": ("u2", 1, None), "16UC1": ("u2", 1, None),
    "rgb8": ("u1", 3, "COLOR_RGB2GRAY"), "bgr8": ("u1", 3, "COLOR_BGR2GRAY"), "8UC3": ("u1", 3, "COLOR_BGR2GRAY"),
    "rgba8": ("u1", 4, "COLOR_RGBA2GRAY"), "bgra8": ("u1", 4, "COLOR_BGRA2GRAY"), "8UC4": ("u1", 4, "COLOR_BGRA2GRAY"),
    "rgb16": ("u2", 3, "COLOR_RGB2GRAY"), "bgr16": ("u2", 3, "COLOR_BGR2GRAY"),
    # OpenCV names a Bayer pattern by its second row, ROS by its first.
    "bayer_rggb8": ("u1", 1, "COLOR_BayerBG2GRAY"), "bayer_bggr8": ("u1", 1, "COLOR_BayerRG2GRAY"),
    "bayer_gbrg8": ("u1", 1, "COLOR_BayerGR2GRAY"), "bayer_grbg8": ("u1", 1, "COLOR_BayerGB2GRAY"),
    "bayer_rggb16": ("u2", 1, "COLOR_BayerBG2GRAY"), "bayer_bggr16": ("u2", 1, "COLOR_BayerRG2GRAY"),
    "bayer_gbrg16": ("u2", 1, "COLOR_BayerGR2GRAY"), "bayer_grbg16": ("u2", 1, "COLOR_BayerGB2GRAY"),
    "yuv422": ("u1", 2, "COLOR_YUV2GRAY_UYVY"), "uyvy": ("u1", 2, "COLOR_YUV2GRAY_UYVY"),
    "yuv422_yuy2": ("u1", 2, "COLOR_YUV2GRAY_YUY2"), "yuyv": ("u1", 2, "COLOR_YUV2GRAY_YUY2"),
}


def is_bag(path: pathlib.Path) -> bool:
    return path.suffix.lower() in SUFFIXES or (path / "metadata.yaml").is_file()


def open_bag(path: pathlib.Path, options: Options) -> Source:
    if path.suffix.lower() == ".mcap" and _has_json_images(path):
        return _open_foxglove(path, options)
    with _reader(path) as reader:
        images = {c.topic: c for c in reader.connections if c.msgtype in (RAW, COMPRESSED)}
        found = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections})) or "nothing"
        topic = _chosen(path, sorted(images), options.topic, found)
        account = Account()
        lens, lens_from = _camera_info(reader, topic, options, account)
        count = sum(c.msgcount for c in reader.connections if c.topic == topic)
        kind = images[topic].msgtype.rsplit("/", 1)[-1]
    return Source(f"bag, topic {topic} ({kind}), {count} pictures", _frames(path, topic, account), account, count, lens, lens_from)


@contextlib.contextmanager
def _reader(path: pathlib.Path):
    """Messages whose definition the bag does not hold are taken to be those of ROS 2 Humble."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore
    try:
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    except Exception as problem:  # the library's errors have no common base class, and a torn file raises Python's own
        raise BadInput(f"{path}: not a bag that can be read ({' '.join(str(problem).split()) or type(problem).__name__})") from None
    try:
        yield reader
    finally:
        reader.close()


def _chosen(path: pathlib.Path, topics: list[str], asked: str | None, found: str) -> str:
    if asked is not None and asked in topics:
        return asked
    if asked is not None:
        raise BadInput(f"{path}: --topic {asked}: no pictures there; topics are {found}")
    if len(topics) == 1:
        return topics[0]
    if not topics:
        raise BadInput(f"{path}: no topic of Image or CompressedImage; topics are {found}")
    raise BadInput(f"{path}: {len(topics)} topics of pictures, choose one by --topic: {', '.join(topics)}")


def _camera_info(reader, topic: str, options: Options, account: Account) -> tuple[Lens | None, str]:
    """The first CameraInfo: beside the pictures' topic, or the only one there is."""
    infos = {c.topic: c for c in reader.connections if c.msgtype == INFO}
    parts = topic.removesuffix("/compressed").rsplit("/", 1)
    name = f"{parts[0]}/camera_info"
    name = name if name in infos else next(iter(infos)) if len(infos) == 1 else None
    if name is None:
        if infos:
            account.assumed.append(f"which CameraInfo belongs to {topic} is not clear ({', '.join(infos)}): none is taken")
        return None, ""
    for connection, _, raw in reader.messages(connections=[infos[name]]):
        info = reader.deserialize(raw, connection.msgtype)
        matrix = np.ravel(getattr(info, "k", getattr(info, "K", ())))
        coefficients = np.ravel(getattr(info, "d", getattr(info, "D", ())))
        if matrix[0] == 0:  # ROS: "may be 0 for an uncalibrated camera"
            account.assumed.append(f"{name} is of a camera without calibration: left out")
            return None, ""
        if "rect" in parts[-1]:
            projection = np.ravel(getattr(info, "p", getattr(info, "P", ())))
            return lens_of(info.width, info.height, projection[[0, 5, 2, 6]], "none", (), name), f"{name}, of rectified pictures"
        return lens_of(info.width, info.height, matrix[[0, 4, 2, 5]], info.distortion_model, coefficients, name), name
    return None, ""


def _frames(path: pathlib.Path, topic: str, account: Account) -> Iterator[Frame]:
    with _reader(path) as reader:
        connections = [c for c in reader.connections if c.topic == topic and c.msgtype in (RAW, COMPRESSED)]
        for connection, received_ns, raw in reader.messages(connections=connections):
            message = reader.deserialize(raw, connection.msgtype)
            time_ns = message.header.stamp.sec * NS + message.header.stamp.nanosec
            if time_ns == 0:
                note = "header.stamp is 0: the times are when the bag received the messages"
                account.assumed += [] if note in account.assumed else [note]
                time_ns = received_ns
            if connection.msgtype == COMPRESSED:
                pixels = decoded(bytes(message.data))
            else:
                pixels = raw_pixels(message, f"{path}: {topic}")
            if pixels is None:
                account.dropped["picture can't be decoded"] += 1
                continue
            yield Frame(time_ns, pixels=pixels)


def decoded(octets: bytes) -> np.ndarray | None:
    """Gray [H,W] of a PNG or JPEG in memory, 8 or 16 bits; None where it can't be decoded."""
    import cv2
    return cv2.imdecode(np.frombuffer(octets, np.uint8), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH) if octets else None


def raw_pixels(message, where: str) -> np.ndarray | None:
    """Gray [H,W] of a sensor_msgs/Image; None where it holds fewer octets than it says."""
    import cv2
    if message.encoding not in ENCODINGS:
        raise BadInput(f"{where}: encoding '{message.encoding}', allowed are {', '.join(ENCODINGS)}")
    kind, channels, conversion = ENCODINGS[message.encoding]
    order = ">" if message.is_bigendian else "<"
    octets = np.frombuffer(bytes(message.data), np.uint8)
    width_octets = message.width * channels * int(kind[1])
    if message.step < width_octets or len(octets) < message.step * message.height:
        return None
    rows = octets[:message.step * message.height].reshape(message.height, message.step)[:, :width_octets]
    pixels = np.ascontiguousarray(rows).view(order + kind).astype(kind).reshape(message.height, message.width, channels)
    return pixels[:, :, 0] if conversion is None else cv2.cvtColor(np.ascontiguousarray(pixels), getattr(cv2, conversion))


def _has_json_images(path: pathlib.Path) -> bool:
    return bool(_foxglove_topics(path))


def _foxglove_topics(path: pathlib.Path) -> list[str]:
    from mcap.exceptions import McapError
    from mcap.reader import make_reader
    try:
        with open(path, "rb") as stream:
            summary = make_reader(stream).get_summary()
    except (OSError, McapError) as problem:
        raise BadInput(f"{path}: not an MCAP file that can be read ({problem})") from None
    if summary is None:
        return []
    kinds = {number: schema.name for number, schema in summary.schemas.items()}
    return sorted(c.topic for c in summary.channels.values() if kinds.get(c.schema_id) == FOXGLOVE_IMAGE and c.message_encoding == "json")


def _open_foxglove(path: pathlib.Path, options: Options) -> Source:
    """As tools/sequence_to_mcap.py writes it."""
    topics = _foxglove_topics(path)
    topic = _chosen(path, topics, options.topic, ", ".join(topics))
    account = Account()
    return Source(f"MCAP, topic {topic} ({FOXGLOVE_IMAGE})", _foxglove_frames(path, topic, account), account)


def _foxglove_frames(path: pathlib.Path, topic: str, account: Account) -> Iterator[Frame]:
    from mcap.reader import make_reader
    with open(path, "rb") as stream:
        for _, _, message in make_reader(stream).iter_messages(topics=[topic]):
            image = json.loads(message.data)
            pixels = decoded(base64.b64decode(image["data"]))
            if pixels is None:
                account.dropped["picture can't be decoded"] += 1
                continue
            yield Frame(image["timestamp"]["sec"] * NS + image["timestamp"]["nsec"], pixels=pixels)
