"""ROS 1 and 2 bags and MCAP files: ROS' and Foxglove's messages of pictures, of encoded video and of the camera."""

import pathlib
import re
from collections.abc import Iterator

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.camera_info import field, lens_of_info, numbers_of
from polhode_ground.importing.decoding import decode
from polhode_ground.importing.lens import Lens
from polhode_ground.importing.message_video import MessageVideo, codec_of
from polhode_ground.importing.recordings import is_recording, opened, read_messages
from polhode_ground.importing.source import NS, Account, Frame, Options, Source, lens_if_any
from polhode_ground.importing.topic_messages import TopicMessages, frame_id_of

RAW = ("sensor_msgs/msg/Image", "foxglove.RawImage", "foxglove_msgs/msg/RawImage")
COMPRESSED = ("sensor_msgs/msg/CompressedImage", "foxglove.CompressedImage", "foxglove_msgs/msg/CompressedImage")
VIDEO = ("foxglove.CompressedVideo", "foxglove_msgs/msg/CompressedVideo", "ffmpeg_image_transport_msgs/msg/FFMPEGPacket")
INFO = ("sensor_msgs/msg/CameraInfo", "foxglove.CameraCalibration", "foxglove_msgs/msg/CameraCalibration")
PICTURES = RAW + COMPRESSED + VIDEO
RECTIFIED = re.compile(r"(^|[/_])rect(ified)?([/_]|$)")  # in the name of a topic, as ROS' image_proc and drivers have it
# Depth cameras' topics and encodings (REP 118). Thermal cameras use 16UC1, too: only both together tell.
DISTANCES = re.compile(r"depth|disparity|distance|range", re.IGNORECASE)
DISTANCE_ENCODINGS = ("16UC1", "32FC1", "mono16")
NEEDED = "give --intrinsics FILE, 'fu,fv,cu,cv' or auto"
# Encodings of sensor_msgs/Image: (type, channels, OpenCV's conversion to gray or None).
ENCODINGS = {
    "mono8": ("u1", 1, None),
    "8UC1": ("u1", 1, None),
    "mono16": ("u2", 1, None),
    "16UC1": ("u2", 1, None),
    "8SC1": ("i1", 1, None),
    "16SC1": ("i2", 1, None),
    "32SC1": ("i4", 1, None),
    "32FC1": ("f4", 1, None),
    "64FC1": ("f8", 1, None),
    "32FC3": ("f4", 3, "COLOR_BGR2GRAY"),
    "rgb8": ("u1", 3, "COLOR_RGB2GRAY"),
    "bgr8": ("u1", 3, "COLOR_BGR2GRAY"),
    "8UC3": ("u1", 3, "COLOR_BGR2GRAY"),
    "rgba8": ("u1", 4, "COLOR_RGBA2GRAY"),
    "bgra8": ("u1", 4, "COLOR_BGRA2GRAY"),
    "8UC4": ("u1", 4, "COLOR_BGRA2GRAY"),
    "rgb16": ("u2", 3, "COLOR_RGB2GRAY"),
    "bgr16": ("u2", 3, "COLOR_BGR2GRAY"),
    "rgba16": ("u2", 4, "COLOR_RGBA2GRAY"),
    "bgra16": ("u2", 4, "COLOR_BGRA2GRAY"),
    "16UC3": ("u2", 3, "COLOR_BGR2GRAY"),
    "16UC4": ("u2", 4, "COLOR_BGRA2GRAY"),
    # OpenCV names a Bayer pattern by its second row, ROS by its first.
    "bayer_rggb8": ("u1", 1, "COLOR_BayerBG2GRAY"),
    "bayer_bggr8": ("u1", 1, "COLOR_BayerRG2GRAY"),
    "bayer_gbrg8": ("u1", 1, "COLOR_BayerGR2GRAY"),
    "bayer_grbg8": ("u1", 1, "COLOR_BayerGB2GRAY"),
    "bayer_rggb16": ("u2", 1, "COLOR_BayerBG2GRAY"),
    "bayer_bggr16": ("u2", 1, "COLOR_BayerRG2GRAY"),
    "bayer_gbrg16": ("u2", 1, "COLOR_BayerGR2GRAY"),
    "bayer_grbg16": ("u2", 1, "COLOR_BayerGB2GRAY"),
    "yuv422": ("u1", 2, "COLOR_YUV2GRAY_UYVY"),
    "uyvy": ("u1", 2, "COLOR_YUV2GRAY_UYVY"),
    "yuv422_yuy2": ("u1", 2, "COLOR_YUV2GRAY_YUY2"),
    "yuyv": ("u1", 2, "COLOR_YUV2GRAY_YUY2"),
}
# Their first plane is the luminance, of as many rows as the picture has; then comes the colour, (rows of both) / (rows of the first).
PLANAR = {"nv12": 1.5, "nv21": 1.5, "i420": 1.5, "yuv420": 1.5, "yv12": 1.5, "nv16": 2, "nv24": 3, "yuv444": 3}


def is_bag(path: pathlib.Path) -> bool:
    return is_recording(path)


def open_bag(path: pathlib.Path, options: Options) -> Source:
    account = Account()
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        account.assumed.append("the files of this folder are taken for parts of one recording, in the order of their names")
    with opened(path) as reader:
        images = {c.topic: c for c in reader.connections if c.msgtype in PICTURES}
        found = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections})) or "nothing"
        filled = [topic for topic, c in images.items() if c.msgcount != 0]
        topic = _chosen(path, _of_light(reader, sorted(filled or images), options.topic, account), options.topic, found)
        messages = TopicMessages()
        for _, received_ns, message in _messages(reader, topic, Account()):
            messages.add(message, stamp_ns(message), received_ns)
        messages.choose(options.camera, f"{path}: {topic}", account)
        lens, lens_from = lens_if_any(lambda: _camera_info(reader, topic, messages.frame_id, account), account)
        kind = images[topic].msgtype.rsplit("/", 1)[-1]
    times_ns = messages.taken(messages.stamps_ns)
    return Source(
        f"bag, topic {topic} ({kind}), {len(times_ns)} pictures",
        _frames(path, topic, messages.left_out, account),
        account,
        count=len(times_ns),
        lens=lens,
        lens_from=lens_from,
        times_ns=times_ns,
        received_ns=messages.taken(messages.received_ns),
    )


def _of_light(reader, topics: list[str], asked: str | None, account: Account) -> list[str]:
    """Topics without those of distances, where there is another."""
    distances = [topic for topic in topics if DISTANCES.search(topic) and _holds_distances(reader, topic)]
    if asked in distances:
        account.assumed.append(f"{asked} holds distances, not light: what is tracked in it are edges of the shape")
    light = [topic for topic in topics if topic not in distances or topic == asked]
    if light and distances and asked is None:
        account.assumed.append(f"topics of distances are left out: {', '.join(distances)}")
    if distances and not light:
        raw = [c.topic for c in reader.connections if c.topic in distances and c.msgtype in RAW]
        raise BadInput(
            f"{', '.join(distances)}: holds distances, allowed are pictures of light{f'; --topic {raw[0]} takes it all the same' if raw else ''}"
        )
    return light


def _holds_distances(reader, topic: str) -> bool:
    """By the first message: a picture beside a depth camera's may have such a name, too."""
    message = next((message for _, _, message in _messages(reader, topic, Account())), None)
    return getattr(message, "encoding", "") in DISTANCE_ENCODINGS or "compressedDepth" in getattr(message, "format", "")


def _chosen(path: pathlib.Path, topics: list[str], asked: str | None, found: str) -> str:
    if asked is not None and asked in topics:
        return asked
    if asked is not None:
        raise BadInput(f"{path}: --topic {asked}: no pictures there; topics are {found}")
    if len(topics) == 1:
        return topics[0]
    if not topics:
        raise BadInput(f"{path}: no topic of Image, CompressedImage or CompressedVideo; topics are {found}")
    raise BadInput(f"{path}: {len(topics)} topics of pictures, choose one by --topic: {', '.join(topics)}")


def _camera_info(reader, topic: str, frame_id: str, account: Account) -> tuple[Lens | None, str]:
    """The first CameraInfo: beside the pictures' topic, or the only one there is."""
    infos = {c.topic: c for c in reader.connections if c.msgtype in INFO}
    parts = topic.removesuffix("/compressed").rsplit("/", 1)
    name = f"{parts[0]}/camera_info"
    name = name if name in infos else next(iter(infos)) if len(infos) == 1 else None
    if name is None:
        if infos:
            raise BadInput(f"which CameraInfo belongs to {topic} is not clear ({', '.join(infos)}): {NEEDED}")
        return None, ""
    messages = [
        (time_ns, reader.deserialize(raw, connection.msgtype)) for connection, time_ns, raw in reader.messages(connections=[infos[name]])
    ]
    if not messages:
        return None, ""
    messages = _of_camera(messages, frame_id, name)
    began_ns, info = messages[0]
    rectified = RECTIFIED.search(topic) is not None
    if not np.ravel(field(info, "p" if rectified else "k", ()))[:1].any():  # ROS: "may be 0 for an uncalibrated camera"
        raise BadInput(f"{name} is of a camera without calibration: {NEEDED}")
    changed = [time_ns for time_ns, other in messages if numbers_of(other) != numbers_of(info)]
    if changed:
        account.assumed.append(
            f"{name} changes: {len(changed)} of {len(messages)} messages differ from the first, from {(changed[0] - began_ns) / NS:.3f} s on: "
            "the first is taken for all pictures, which is wrong for those; leave them out by --to"
        )
    return lens_of_info(info, rectified, name), f"{name}, of rectified pictures" if rectified else name


def _of_camera(messages: list[tuple], frame_id: str, name: str) -> list[tuple]:
    """Those of the pictures' camera, where several cameras tell theirs on one topic."""
    found = sorted({frame_id_of(info) for _, info in messages})
    if len(found) < 2 or all(numbers_of(info) == numbers_of(messages[0][1]) for _, info in messages):
        return messages
    if frame_id not in found:
        raise BadInput(f"{name} is of several cameras ({', '.join(found)}), and the pictures are of '{frame_id}': {NEEDED}")
    return [(time_ns, info) for time_ns, info in messages if frame_id_of(info) == frame_id]


def _messages(reader, topic: str, account: Account) -> Iterator[tuple]:
    """(connection, time received, message) of the pictures."""
    return read_messages(reader, [c for c in reader.connections if c.topic == topic and c.msgtype in PICTURES], account)


def _frames(path: pathlib.Path, topic: str, left_out: set[int], account: Account) -> Iterator[Frame]:
    with opened(path) as reader:
        video = MessageVideo(f"{path}: {topic}", account)
        for number, (connection, _, message) in enumerate(_messages(reader, topic, account)):
            if number in left_out:
                continue
            time_ns = stamp_ns(message)
            if connection.msgtype in VIDEO or codec_of(message):
                yield from video.feed(message, time_ns)
                continue
            pixels = _pixels(message, connection.msgtype, f"{path}: {topic}", account)
            if pixels is None:
                account.dropped["picture can't be decoded"] += 1
                continue
            yield Frame(time_ns, pixels=pixels)
        yield from video.finish()


def stamp_ns(message) -> int:
    """Names of seconds and nanoseconds are those of ROS, of Protobuf, of Foxglove's JSON; Protobuf's own JSON has a date as text."""
    stamp = message.header.stamp if hasattr(message, "header") else message.timestamp
    if isinstance(stamp, str):
        return int(np.datetime64(stamp.removesuffix("Z"), "ns").astype(np.int64))
    seconds, nanoseconds = (
        next((int(getattr(stamp, name)) for name in names if hasattr(stamp, name)), 0)
        for names in (("sec", "seconds", "secs"), ("nanosec", "nanos", "nsec", "nsecs"))
    )
    return seconds * NS + nanoseconds


def _pixels(message, msgtype: str, where: str, account: Account) -> np.ndarray | None:
    if msgtype in RAW:
        return raw_pixels(message, where)
    if "compressedDepth" in message.format:
        raise BadInput(f"{where}: '{message.format}' holds distances, allowed are pictures of light")
    return decoded(bytes(message.data), message.format, account)


def mosaic_of(said: str, octets: bytes) -> str | None:
    """The mosaic that a compressed picture is, by CompressedImage's format: "bayer_rggb8; png compressed bayer_rggb8"."""
    import cv2

    compressed = re.search(r"compressed\s+(\w+)", said)  # what was compressed, after conversions
    named = compressed.group(1) if compressed else next(iter(re.findall(r"bayer_\w+", said)), "")
    if not named.startswith("bayer_") or named not in ENCODINGS:
        return None
    pixels = cv2.imdecode(np.frombuffer(octets, np.uint8), cv2.IMREAD_UNCHANGED)
    return named if pixels is not None and pixels.ndim == 2 else None  # colours: the mosaic is gone


def decoded(octets: bytes, said: str = "", account: Account | None = None) -> np.ndarray | None:
    """Gray [H,W] of a compressed picture in memory; None where it can't be decoded. @param said  CompressedImage's format"""
    import cv2

    try:
        pixels = decode(octets, "message").pixels
    except BadInput:
        return None
    mosaic = mosaic_of(said, octets)
    if mosaic is None:
        return pixels
    if account is not None:
        account.note(f"the pictures are mosaics ({mosaic}, as their format says) and became gray")
    return cv2.cvtColor(pixels, getattr(cv2, ENCODINGS[mosaic][2]))


def raw_pixels(message, where: str) -> np.ndarray | None:
    """Gray [H,W] of an Image or RawImage; None where it holds fewer octets than it says."""
    import cv2

    octets = np.frombuffer(bytes(message.data), np.uint8)
    if message.encoding.lower() in PLANAR:
        return _luminance(message, octets, PLANAR[message.encoding.lower()])
    if message.encoding not in ENCODINGS:
        raise BadInput(f"{where}: encoding '{message.encoding}', allowed are {', '.join([*ENCODINGS, *PLANAR])}")
    kind, channels, conversion = ENCODINGS[message.encoding]
    order = ">" if getattr(message, "is_bigendian", 0) else "<"
    width_octets = message.width * channels * int(kind[1])
    if message.step < width_octets or len(octets) < message.step * message.height:
        return None
    rows = octets[: message.step * message.height].reshape(message.height, message.step)[:, :width_octets]
    pixels = np.ascontiguousarray(rows).view(order + kind).astype(kind).reshape(message.height, message.width, channels)
    return pixels[:, :, 0] if conversion is None else cv2.cvtColor(np.ascontiguousarray(pixels), getattr(cv2, conversion))


def _luminance(message, octets: np.ndarray, planes: float) -> np.ndarray | None:
    """The first plane. Some drivers count the rows of colour into `height`."""
    step, height = max(message.step, message.width), message.height
    if len(octets) < round(step * height * planes):
        height = round(height / planes) if len(octets) >= step * height else 0
    if not height:
        return None
    return np.ascontiguousarray(octets[: step * height].reshape(height, step)[:, : message.width])
