"""MCAP files of any writer: messages in CDR, ROS 1's form, Protobuf and JSON; without a summary, cut, or with damaged chunks.

`McapFile` offers what `recordings.py` uses of `rosbags`' reader.
"""

import base64
import binascii
import json
import pathlib
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from types import SimpleNamespace

from polhode_ground.common.errors import BadInput

# (encoding of the messages, encoding of their schema) that can be read.
READABLE = {("cdr", "ros2msg"), ("cdr", "ros2idl"), ("ros1", "ros1msg"), ("protobuf", "protobuf"), ("json", "jsonschema"), ("json", "")}
MAGIC = b"\x89MCAP0\r\n"


@dataclass(frozen=True)
class Connection:
    """A channel, by the names of `rosbags`."""

    id: int
    topic: str
    msgtype: str
    msgcount: int | None  # None: the file does not tell
    encoding: str  # of its messages


def ros_name(name: str) -> str:
    """sensor_msgs/Image of ROS 1 by its name in ROS 2; others as they are."""
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else name


class McapFile:
    """Reads by the index of chunks where there is one, else from the beginning on as far as it goes."""

    def __init__(self, path: pathlib.Path):
        self.path, self.damage = path, []
        with open(path, "rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise BadInput(f"{path}: not an MCAP file that can be read (its first octets are not MCAP's)")
        self.summary = self._summary()
        self.schemas, self.channels = (self.summary.schemas, self.summary.channels) if self.summary else ({}, {})
        self.indexed = bool(self.summary and self.summary.chunk_indexes)
        if not self.indexed:
            self._scan()
        if not self.channels:
            raise BadInput(f"{path}: not an MCAP file that can be read ({'; '.join(self.damage) or 'it holds no channels'})")
        self.connections = [self._connection(channel) for channel in self.channels.values()]
        self._decoders = {}

    def _summary(self):
        from mcap.exceptions import McapError
        from mcap.reader import SeekingReader

        try:
            with open(self.path, "rb") as stream:
                return SeekingReader(stream).get_summary()
        except (McapError, OSError, ValueError, EOFError) as problem:
            self.damage.append(f"no index at its end ({words_of(problem)}): read from its beginning on")
            return None

    def _scan(self) -> None:
        """Finds the channels of a file without an index, and how many messages each has."""
        from mcap.records import Channel, Message, Schema

        self._counts = Counter()
        for record in self._records(None):
            if isinstance(record, Schema):
                self.schemas[record.id] = record
            elif isinstance(record, Channel):
                self.channels[record.id] = record
            elif isinstance(record, Message):
                self._counts[record.channel_id] += 1

    def _connection(self, channel) -> Connection:
        schema = self.schemas.get(channel.schema_id)
        if not self.indexed:
            count = self._counts[channel.id]
        else:
            count = self.summary.statistics.channel_message_counts.get(channel.id, 0) if self.summary.statistics else None
        return Connection(
            channel.id,
            channel.topic,
            ros_name(schema.name) if schema and schema.name else "without a type",
            count,
            channel.message_encoding,
        )

    def _records(self, channels: set[int] | None) -> Iterator:
        """All that can be read of these channels; None: of all. A chunk that is damaged costs itself."""
        from mcap.records import Chunk
        from mcap.stream_reader import breakup_chunk

        broken = 0
        for record in self._indexed_chunks(channels) if self.indexed else self._in_a_row():
            if not isinstance(record, Chunk):
                yield record
                continue
            try:
                inside = breakup_chunk(record, validate_crc=True)
            except Exception:  # lz4, zstandard and struct have errors of their own
                broken += 1
                continue
            yield from inside
        if broken:
            self._note(f"{broken} chunks can't be unpacked")

    def _indexed_chunks(self, channels: set[int] | None) -> Iterator:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Chunk

        with open(self.path, "rb") as stream:
            for index in sorted(self.summary.chunk_indexes, key=lambda one: one.message_start_time):
                if channels is not None and index.message_index_offsets and not channels & set(index.message_index_offsets):
                    continue
                stream.seek(index.chunk_start_offset + 9)  # after the record's opcode and length
                try:
                    chunk = Chunk.read(ReadDataStream(stream))
                except Exception as problem:
                    self._note(f"a chunk can't be read: {words_of(problem)}")
                    continue
                yield chunk

    def _in_a_row(self) -> Iterator:
        from mcap.stream_reader import StreamReader

        with open(self.path, "rb") as stream:
            try:
                yield from StreamReader(stream, emit_chunks=True, record_size_limit=self.path.stat().st_size).records
            except GeneratorExit:
                raise
            except Exception as problem:
                self._note(f"cut or damaged from octet {stream.tell()} of {self.path.stat().st_size} on ({words_of(problem)})")

    def _note(self, text: str) -> None:
        if text not in self.damage:
            self.damage.append(text)

    def messages(self, connections: Collection[Connection]) -> Iterator[tuple[Connection, int, object]]:
        """(connection, time received, what `deserialize` takes)."""
        from mcap.records import Message

        by_id = {one.id: one for one in connections}
        for record in self._records(set(by_id)):
            if isinstance(record, Message) and record.channel_id in by_id:
                yield by_id[record.channel_id], record.log_time, record

    def deserialize(self, record, msgtype: str):
        """Fields by attributes, whatever the encoding."""
        channel = self.channels[record.channel_id]
        if channel.id not in self._decoders:
            self._decoders[channel.id] = self._decoder(channel, self.schemas.get(channel.schema_id), msgtype)
        return self._decoders[channel.id](record.data)

    def _decoder(self, channel, schema, msgtype: str):
        encoding = schema.encoding if schema else ""
        if (channel.message_encoding, encoding) not in READABLE:
            raise BadInput(
                f"{self.path}: topic {channel.topic} ({msgtype}) in '{channel.message_encoding}' with a schema in '{encoding}', "
                "allowed are CDR, ROS 1, Protobuf and JSON"
            )
        if channel.message_encoding == "protobuf":
            from mcap_protobuf.decoder import DecoderFactory

            return DecoderFactory().decoder_for("protobuf", schema)
        if channel.message_encoding == "json":
            return of_json
        return ros_decoder(schema.data.decode(errors="replace"), schema.encoding, channel.message_encoding, msgtype)


def ros_decoder(text: str, language: str, encoding: str, msgtype: str):
    """@param text  the message's definition, in `language`; empty: that of ROS 2 Humble"""
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    if not text.strip():
        store = ros_store()
    elif language == "ros2idl":
        parts = [part.split("\n", 1)[1] if part.startswith("IDL:") else part for part in text.split("=" * 80 + "\n") if part.strip()]
        store = _store_of({name: fields for part in parts for name, fields in get_types_from_idl(part).items()})
    else:
        store = _store_of(get_types_from_msg(text, msgtype))
    read = store.deserialize_ros1 if encoding == "ros1" else store.deserialize_cdr
    return lambda raw: read(raw, msgtype)


def _store_of(types: dict):
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.EMPTY)
    store.register(types)
    return store


# Messages that are not ROS' own, as their packages define them; bags of SQLite do not hold definitions.
PICTURES_OF_OTHERS = {
    "foxglove_msgs/msg/CompressedVideo": "builtin_interfaces/Time timestamp\nstring frame_id\nuint8[] data\nstring format",
    "foxglove_msgs/msg/CompressedImage": "builtin_interfaces/Time timestamp\nstring frame_id\nuint8[] data\nstring format",
    "foxglove_msgs/msg/RawImage": "builtin_interfaces/Time timestamp\nstring frame_id\nuint32 width\nuint32 height\nstring encoding\nuint32 step\nuint8[] data",
    "ffmpeg_image_transport_msgs/msg/FFMPEGPacket": "std_msgs/Header header\nint32 width\nint32 height\nstring encoding\nuint64 pts\nuint8 flags\nbool is_bigendian\nuint8[] data",
}


def ros_store():
    """The messages of ROS 2 Humble, and those of others that hold pictures."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in PICTURES_OF_OTHERS.items():
        store.register(get_types_from_msg(text, name))
    return store


def of_json(raw: bytes) -> SimpleNamespace:
    message = json.loads(raw, object_hook=lambda fields: SimpleNamespace(**fields))
    data = getattr(message, "data", None)
    if isinstance(data, str):
        try:
            message.data = base64.b64decode(data, validate=True)
        except binascii.Error as problem:
            raise ValueError(f"'data' is not base64: {problem}") from None
    elif isinstance(data, list):
        message.data = bytes(data)
    return message


def words_of(problem: BaseException) -> str:
    return " ".join(str(problem).split()) or type(problem).__name__
