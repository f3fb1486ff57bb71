"""The newest image: of the sequence that a run plays, or of the recording that it writes. Packets carry none."""

import pathlib
import struct
import zlib
from collections import deque

import lz4.block
import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import depth_for, eight_bits
from polhode_ground.common.sequence import Camera, Sequence, read_sequence

# platform/recording/record.hpp: magic, kind, flags, packing, reason, width, height, count, time, octets, CRC of the content, 4 spare, CRC of all that
HEADER = struct.Struct("<4s4B2HIqII4xI")
MAGIC, BEGIN, FRAME = b"PHR1", 1, 2
READABLE, DEEP = 1, 2
DIFFERENCE_LZ4 = 1
LZ4_RATIO = 255  # no block unpacks to more than so many times its length
FRAMES_MAX = 64  # of which one is shown: packets are not later than that many frames


class SequenceImages:
    """By the frame's time, as `polhode run` plays it: forth, back, forth."""

    def __init__(self, folder: pathlib.Path):
        self._sequence: Sequence = read_sequence(folder)
        self._shown_ns = -1
        self.camera: Camera | None = self._sequence.camera
        self.problem = ""  # why there is no image of the time last asked for

    def newest(self, timestamp_ns: int) -> tuple[int, np.ndarray] | None:
        """(time, gray [H,W] uint8) of the frame of that time; None where it is that of the last call, or there is a problem."""
        if timestamp_ns == self._shown_ns:
            return None
        self._shown_ns, self.problem = timestamp_ns, ""
        stamps = self._sequence.timestamp_ns
        span = int(stamps[-1] - stamps[0])
        along = timestamp_ns - int(stamps[0])
        if span > 0 and along > span:
            along %= 2 * span
            along = min(along, 2 * span - along)
        index = int(np.searchsorted(stamps, int(stamps[0]) + along))
        if index == len(stamps) or int(stamps[index]) != int(stamps[0]) + along:
            self.problem = "the sequence has no frame of this time: the run plays another one"
            return None
        try:
            return timestamp_ns, self._sequence.read_gray(index)
        except BadInput as problem:
            self.problem = str(problem)
            return None


class RecordingImages:
    """The newest frame with a packet in a folder of recordings (recording.folder), which may still be empty."""

    def __init__(self, folder: pathlib.Path):
        self._folder = folder
        self._file: pathlib.Path | None = None
        self._at = 0  # of the first record that has not been looked at
        self._frames: deque[tuple[int, tuple]] = deque(maxlen=FRAMES_MAX)  # place and header of the last ones
        self._shown_ns = -1
        self._largest = 0
        self.camera: Camera | None = None
        self.problem = ""  # why there is no image

    def newest(self, timestamp_ns: int) -> tuple[int, np.ndarray] | None:
        """(time, gray [H,W] uint8) of the newest frame not after that time, as a frame is recorded before its packet is sent; None where
        that is the one of the last call."""
        file = max(self._folder.glob("recording-*.rec"), default=None)
        if file is None:
            self.problem = f"{self._folder}: holds no recording as yet"
            return None
        if file != self._file:
            self._file, self._at = file, 0
            self._frames.clear()
        try:
            with open(file, "rb") as stream:
                self.problem = ""
                self._follow(stream)
                found = next((one for one in reversed(self._frames) if one[1][8] <= timestamp_ns), None)
                return self._picture(stream, *found) if found is not None and found[1][8] != self._shown_ns else None
        except (OSError, ValueError, lz4.block.LZ4BlockError) as problem:
            self.problem = f"{file}: {getattr(problem, 'strerror', None) or problem}"
            return None

    def _follow(self, stream) -> None:
        """From header to header, to the last record that is whole."""
        size = stream.seek(0, 2)
        while self._at + HEADER.size <= size:
            stream.seek(self._at)
            octets = stream.read(HEADER.size)
            header = HEADER.unpack(octets)
            if header[0] != MAGIC or zlib.crc32(octets[:-4]) != header[-1] or self._at + HEADER.size + header[9] > size:
                return
            if header[1] == BEGIN:
                self.camera = camera_of(stream.read(header[9]).decode("utf-8", "replace"))
            elif header[1] == FRAME and header[2] & READABLE:
                self._frames.append((self._at + HEADER.size, header))
            self._at += HEADER.size + header[9]

    def _picture(self, stream, place: int, header: tuple) -> tuple[int, np.ndarray] | None:
        _, _, flags, packing, _, width, height, _, stamp, length, crc, _ = header
        stream.seek(place)
        content = stream.read(length)
        pixel = 2 if flags & DEEP else 1
        possible = width * height * pixel <= LZ4_RATIO * (length + 1) if packing == DIFFERENCE_LZ4 else width * height * pixel == length
        if zlib.crc32(content) != crc or not possible or width * height == 0:
            self.problem = "a damaged record"
            return None
        if packing == DIFFERENCE_LZ4:
            content = lz4.block.decompress(content, uncompressed_size=width * height * pixel)
        octets = np.frombuffer(content, np.uint8).reshape(height, width, pixel)
        if packing == DIFFERENCE_LZ4:
            octets = np.add.accumulate(octets, axis=1, dtype=np.uint8)  # differences to the left neighbour, octet by octet
        self._shown_ns = stamp
        if not flags & DEEP:
            return stamp, octets[:, :, 0]
        levels = np.ascontiguousarray(octets).view("<u2")[:, :, 0]
        self._largest = max(self._largest, int(levels.max(initial=0)))
        return stamp, eight_bits(levels, depth_for(self._largest))


def camera_of(parameters: str) -> Camera | None:
    """Of a run's parameters as text, `camera.fu_px = 888.9` a line; None where they name none."""
    found = dict(line.split(" = ", 1) for line in parameters.splitlines() if line.startswith("camera.") and " = " in line)
    try:
        number = {name.removeprefix("camera."): float(value) for name, value in found.items()}
        return Camera(
            int(number["width_px"]),
            int(number["height_px"]),
            np.array([number[name] for name in ("fu_px", "fv_px", "cu_px", "cv_px")]),
            np.array([number[name] for name in ("k1", "k2", "p1", "p2")]),
        )
    except (KeyError, ValueError):
        return None


def open_images(folder: pathlib.Path) -> SequenceImages | RecordingImages:
    """@errors BadInput: no such folder, or a sequence that can't be read."""
    if not folder.is_dir():
        raise BadInput(f"--images {folder}: no such folder")
    return SequenceImages(folder) if (folder / "mav0").is_dir() else RecordingImages(folder)
