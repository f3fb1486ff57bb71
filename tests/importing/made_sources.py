"""Writes frames as people keep them: videos, folders, bags. Frames are [H,W] uint8 with times in nanoseconds."""

import fractions
import pathlib

import numpy as np
from PIL import Image

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SAMPLE = REPOSITORY / "hil/data/sample"
INTRINSICS = "888.8888888888889,888.8888888888889,319.5,239.5"
NS = 1_000_000_000


def write_video(path: pathlib.Path, frames, times_s, rotation_deg: int = 0, preset: str = "ultrafast") -> None:
    """H.264 with the times as they are, in ticks of a millisecond; nearly without loss."""
    import av
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "4", "preset": preset})
        stream.height, stream.width = frames[0].shape
        stream.pix_fmt = "yuv420p"
        stream.time_base = stream.codec_context.time_base = fractions.Fraction(1, 1000)
        for pixels, time_s in zip(frames, times_s):
            frame = av.VideoFrame.from_ndarray(np.repeat(pixels[:, :, None], 3, axis=2), format="rgb24")
            frame.pts, frame.time_base = round(time_s * 1000), fractions.Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    if rotation_deg:
        _set_rotation(path, rotation_deg)


def _set_rotation(path: pathlib.Path, rotation_deg: int) -> None:
    """Writes the matrix of the track's header (ISO 14496-12, tkhd), which players turn by."""
    octets = bytearray(path.read_bytes())
    at = octets.index(b"tkhd") + 4 + 4 + 36  # version and flags, then what stands before the matrix in version 0
    turn = {90: (0, 1, -1, 0), 180: (-1, 0, 0, -1), 270: (0, -1, 1, 0)}[rotation_deg]
    for place, value in zip((0, 4, 12, 16), turn):
        octets[at + place:at + place + 4] = (value * 65536).to_bytes(4, "big", signed=True)
    path.write_bytes(octets)


def write_pictures(folder: pathlib.Path, frames, names, exif=None) -> None:
    folder.mkdir(parents=True)
    for index, (pixels, name) in enumerate(zip(frames, names)):
        extra = {"exif": exif(index)} if exif else {}
        Image.fromarray(pixels).save(folder / name, quality=95, **extra)


def exif_of(time: str | None = None, focal_35mm: int | None = None, orientation: int | None = None):
    exif = Image.Exif()
    fields = exif.get_ifd(0x8769)
    if time:
        fields[0x9003], fields[0x9291] = time.split(".")[0], time.split(".")[1]
    if focal_35mm:
        fields[0xA405] = focal_35mm
    if orientation:
        exif[0x0112] = orientation
    return exif


def ros_types(version: int):
    from rosbags.typesys import Stores, get_typestore
    return get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)


def image_message(store, pixels, time_ns: int, encoding: str = "mono8", padding: int = 0):
    Image_, Header, Time = (store.types[name] for name in ("sensor_msgs/msg/Image", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"))
    height, width = pixels.shape[:2]
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, -1)
    rows = np.pad(rows, ((0, 0), (0, padding)))
    return Image_(header=_header(Header, Time, time_ns), height=height, width=width, encoding=encoding, is_bigendian=0,
                  step=rows.shape[1], data=rows.ravel())


def compressed_message(store, octets: bytes, time_ns: int):
    Compressed, Header, Time = (store.types[name] for name in ("sensor_msgs/msg/CompressedImage", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"))
    return Compressed(header=_header(Header, Time, time_ns), format="png", data=np.frombuffer(octets, np.uint8))


def info_message(store, width, height, matrix, coefficients, model="plumb_bob"):
    """ROS 1 writes K, D, R, P where ROS 2 writes k, d, r, p."""
    Info, Header, Time, Region = (store.types[name] for name in ("sensor_msgs/msg/CameraInfo", "std_msgs/msg/Header", "builtin_interfaces/msg/Time",
                                                                 "sensor_msgs/msg/RegionOfInterest"))
    fields = {"k": np.array(matrix, float).ravel(), "d": np.array(coefficients, float), "r": np.eye(3).ravel(),
              "p": np.column_stack([np.array(matrix, float).reshape(3, 3), np.zeros(3)]).ravel()}
    if "K" in Info.__dataclass_fields__:
        fields = {name.upper(): value for name, value in fields.items()}
    return Info(header=_header(Header, Time, 0), height=height, width=width, distortion_model=model, binning_x=0, binning_y=0,
                roi=Region(x_offset=0, y_offset=0, height=0, width=0, do_rectify=False), **fields)


def _header(Header, Time, time_ns: int):
    extra = {"seq": 0} if "seq" in Header.__dataclass_fields__ else {}
    return Header(stamp=Time(sec=time_ns // NS, nanosec=time_ns % NS), frame_id="camera", **extra)


def write_bag(path: pathlib.Path, version: int, messages, storage: str = "SQLITE3") -> None:
    """messages: (topic, time received [ns], message) in order. @param version  of ROS: 1 or 2"""
    write_messages(path, ros_types(version), messages, version, storage)


def write_messages(path: pathlib.Path, store, messages, version: int = 2, storage: str = "SQLITE3") -> None:
    if version == 1:
        from rosbags.rosbag1 import Writer
        writer, serialise = Writer(path), store.serialize_ros1
    else:
        from rosbags.rosbag2 import StoragePlugin, Writer
        writer, serialise = Writer(path, version=9, storage_plugin=StoragePlugin[storage]), store.serialize_cdr
    connections = {}
    with writer:
        for topic, time_ns, message in messages:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], time_ns, serialise(message, kind))
