"""Recorded streams of IP cameras: JPEGs with headers between them, which may hold their times."""

import io

import numpy as np
import pytest
from PIL import Image
from polhode_ground.importing.plan import Part, Plan
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Options

NS = 1_000_000_000
STEPS_MS = [0, 200, 400, 600, 1200, 1400, 1600, 1800]
SERVER = b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=frame\r\n\r\n"


def stream(path, field, before=b""):
    """@param field  a part's own line, of its number and its time [ms]; none where it is empty"""
    with open(path, "wb") as file:
        file.write(before)
        for i, time_ms in enumerate(STEPS_MS):
            octets = io.BytesIO()
            Image.fromarray(np.full((48, 64), 30 * i, np.uint8)).save(octets, "JPEG")
            head = [b"--frame", b"Content-Type: image/jpeg", b"Content-Length: %d" % len(octets.getvalue()), field(i, 1_700_000_000_000 + time_ms).encode()]
            file.write(b"\r\n".join(line for line in head if line) + b"\r\n\r\n" + octets.getvalue() + b"\r\n")
    return path


def taken(path, **options):
    source = open_source(path, Options(**options))
    frames = list(Plan(source, Part()).frames())
    return [(frame.timestamp_ns, round(int(frame.pixels[0, 0]) / 30)) for frame in frames], " ".join(source.account.assumed), source.nominal_time


# verifies: GND-03
@pytest.mark.parametrize(("field", "before"), [
    (lambda _, ms: f"X-Timestamp: {ms / 1000:.6f}", b""), (lambda _, ms: f"X-TimeStamp: {ms}", b""), (lambda _, ms: f"X-Timestamp: {ms / 1000:.6f}", SERVER)])
def test_times_in_the_headers_of_parts(tmp_path, field, before):
    for options in ({}, {"rate_hz": 5.0}):
        frames, said, is_nominal = taken(stream(tmp_path / "cam.mjpeg", field, before), **options)
        assert frames == [(1_700_000_000 * NS + ms * 1_000_000, i) for i, ms in enumerate(STEPS_MS)] and not is_nominal
        assert "the times are those of X-Timestamp in the headers of its parts" in said and ("--rate-hz is left out" in said) == bool(options)


# verifies: GND-03
@pytest.mark.parametrize(("field", "says"), [
    (lambda i, ms: f"X-Timestamp: {ms}" if i != 3 else "", "X-Timestamp in the headers of its parts is not read: 1 of 8 have none that is a time"),
    (lambda i, ms: f"Date: Tue, 14 Nov 2023 22:13:2{ms // 1000 % 10} GMT", "Date in the headers of its parts is not read: it repeats or runs back, as whole seconds do"),
    (lambda i, ms: "X-Framerate: 5", "a bare mpjpeg stream tells no times")])
def test_times_that_can_not_be_used_are_told(tmp_path, field, says):
    frames, said, is_nominal = taken(stream(tmp_path / "cam.mjpeg", field))
    assert frames == [(i * NS, i) for i in range(8)] and says in said and is_nominal
    assert taken(tmp_path / "cam.mjpeg", rate_hz=5.0)[0] == [(i * NS // 5, i) for i in range(8)]
