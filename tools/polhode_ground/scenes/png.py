"""PNG reader and writer for gray and RGB, 8 and 16 bit. Own code so that the files depend on nothing but zlib."""

import struct
import zlib

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def _chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def encode(image):
    """PNG bytes of an image (H, W) or (H, W, 3), uint8 or uint16."""
    height, width = image.shape[:2]
    channels = 1 if image.ndim == 2 else image.shape[2]
    bits = 16 if image.dtype == np.uint16 else 8
    stride = channels * bits // 8
    raw = np.ascontiguousarray(image.astype(">u2") if bits == 16 else image).view(np.uint8)
    raw = raw.reshape(height, width * stride).astype(np.int16)
    left = np.zeros_like(raw)
    left[:, stride:] = raw[:, :-stride]
    up = np.zeros_like(raw)
    up[1:] = raw[:-1]
    coded = np.stack([c.astype(np.uint8) for c in (raw, raw - left, raw - up)])
    # The usual heuristic over the cheap filters: per row the one with the smallest sum of absolute differences.
    cost = np.abs(coded.view(np.int8).astype(np.int16)).sum(axis=2, dtype=np.int32)
    choice = np.argmin(cost, axis=0)
    lines = np.empty((height, 1 + width * stride), dtype=np.uint8)
    lines[:, 0] = choice
    lines[:, 1:] = coded[choice, np.arange(height)]
    header = struct.pack(">IIBBBBB", width, height, bits, 0 if channels == 1 else 2, 0, 0, 0)
    data = zlib.compress(lines.tobytes(), 6)
    return SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", data) + _chunk(b"IEND", b"")


def _unfilter(kind, line, previous, stride):
    """One decoded row; line and previous are uint8 rows."""
    if kind == 0:
        return line
    if kind == 2:
        return line + previous
    out, before = line.tolist(), previous.tolist()
    for i in range(len(out)):
        a = out[i - stride] if i >= stride else 0
        if kind == 1:
            out[i] = (out[i] + a) & 255
        elif kind == 3:
            out[i] = (out[i] + (a + before[i]) // 2) & 255
        else:
            b, c = before[i], before[i - stride] if i >= stride else 0
            p = a + b - c
            pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
            out[i] = (out[i] + (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255
    return np.array(out, dtype=np.uint8)


def decode(data):
    """Image (H, W) or (H, W, 3) from the bytes of a PNG as encode writes it (not interlaced, no palette)."""
    if data[:8] != SIGNATURE:
        raise ValueError("not a PNG file")
    position, body, header = 8, b"", None
    while position < len(data):
        length, kind = struct.unpack(">I4s", data[position : position + 8])
        payload = data[position + 8 : position + 8 + length]
        header = struct.unpack(">IIBBBBB", payload) if kind == b"IHDR" else header
        body += payload if kind == b"IDAT" else b""
        position += 12 + length
    width, height, bits, color = header[:4]
    channels = {0: 1, 2: 3}[color]
    stride = channels * bits // 8
    lines = np.frombuffer(zlib.decompress(body), dtype=np.uint8).reshape(height, 1 + width * stride)
    out = np.zeros((height, width * stride), dtype=np.uint8)
    previous = np.zeros(width * stride, dtype=np.uint8)
    for y in range(height):
        out[y] = previous = _unfilter(int(lines[y, 0]), lines[y, 1:], previous, stride)
    image = out.view(">u2").astype(np.uint16) if bits == 16 else out
    return image.reshape((height, width) if channels == 1 else (height, width, 3))
