"""Pictures of a sequence are shown as bright as a replay sees them, on the page and in recordings."""

import base64
import json
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image, PngImagePlugin
from polhode_ground.common.levels import depth_for, significant_bits, viewable
from polhode_ground.common.sequence import Camera, Sequence, read_json
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.transforms.footage import write_sensor_yaml

GRAY = np.linspace(0, 255, 48 * 64).round().astype(np.uint8).reshape(48, 64)


def png(path, pixels, sbit=0):
    said = PngImagePlugin.PngInfo()
    if sbit:
        said.add(b"sBIT", bytes([sbit]))
    Image.fromarray(pixels).save(path, pnginfo=said)


def sequence_of(folder, pictures, sbit=0, suffix=".png"):
    data = folder / "mav0/cam0/data"
    data.mkdir(parents=True)
    for index, pixels in enumerate(pictures):
        if suffix == ".png":
            png(data / f"{index}.png", pixels, sbit)
        else:
            (data / f"{index}.pgm").write_bytes(f"P5 64 48 {65535 if pixels.dtype == np.uint16 else 255}\n".encode() + pixels.astype(pixels.dtype.newbyteorder(">")).tobytes())
    names = [f"{index}{suffix}" for index in range(len(pictures))]
    (folder / "mav0/cam0/data.csv").write_text("#timestamp [ns],filename\n" + "".join(f"{index},{name}\n" for index, name in enumerate(names)))
    return Sequence(folder, None, np.arange(len(names)), names)


# The same table as of the program in tests/replay/test_depth.py.
@pytest.mark.parametrize(("factor", "sbit", "suffix", "bits"), [
    (1, 0, ".png", 8), (4, 0, ".png", 10), (16, 0, ".png", 12), (64, 0, ".png", 14), (16, 12, ".png", 12), (16, 0, ".pgm", 12), (256, 12, ".png", 16)])
def test_depth_is_found_as_the_replay_finds_it(tmp_path, factor, sbit, suffix, bits):
    sequence = sequence_of(tmp_path, [GRAY.astype(np.uint16) * factor] * 3, sbit, suffix)
    assert np.array_equal(sequence.read_gray(0), GRAY) and sequence.depth_bits == bits


def test_dark_pictures_that_say_16_bits_stay_dark(tmp_path):
    assert np.array_equal(sequence_of(tmp_path, [GRAY.astype(np.uint16) * 16], 16).read_gray(0), GRAY // 16)


def test_what_a_replay_found_holds(tmp_path):
    sequence = sequence_of(tmp_path, [GRAY.astype(np.uint16) * 16])
    sequence.see_as({"depth_bits": 14, "mosaic": True})
    smooth = sequence.read_gray(0)
    assert smooth[10, 20] == GRAY[10, 20] // 4 and read_json(tmp_path / "none.json") == {}


def test_depths_and_words_of_files(tmp_path):
    assert [depth_for(level) for level in (255, 256, 4095, 16383, 16384)] == [8, 10, 12, 14, 16]
    assert significant_bits(b"P5\n# 1 2\n64 48 4095\n") == 16 and significant_bits(b"P5 64 48 65535\n") == 0
    assert viewable(b"\xff\xd8\xff\xe0") == "jpeg" and viewable(b"P5 64 48 255\n") is None


@pytest.mark.parametrize(("pixels", "suffix", "converted"), [(GRAY, ".png", False), (GRAY, ".pgm", True), (GRAY.astype(np.uint16) * 16, ".png", True)])
def test_an_mcap_holds_what_viewers_show(tmp_path, pixels, suffix, converted):
    from mcap.reader import make_reader
    sequence = sequence_of(tmp_path / "SEQ", [pixels], suffix=suffix)
    (tmp_path / "SEQ/mav0/cam0/data.csv").open("a").write(f"700000000,torn{suffix}\n")
    write_sensor_yaml(tmp_path / "SEQ/mav0/cam0/sensor.yaml", Camera(64, 48, np.array([100.0, 100.0, 31.5, 23.5]), np.zeros(4)), 1.43)
    (tmp_path / f"SEQ/mav0/cam0/data/torn{suffix}").write_bytes(b"P5 torn")
    done = subprocess.run([sys.executable, REPOSITORY / "tools/sequence_to_mcap.py", sequence.folder, "--out", tmp_path / "run.mcap"], capture_output=True, text=True)
    assert done.returncode == 0 and ("1 images were converted" in done.stderr) == converted and "1 images can't be read" in done.stderr, done.stderr
    with open(tmp_path / "run.mcap", "rb") as stream:
        (image,) = [json.loads(message.data) for _, _, message in make_reader(stream).iter_messages()]
    (tmp_path / "shown").write_bytes(base64.b64decode(image["data"]))
    assert image["format"] == "png" and np.array_equal(np.asarray(Image.open(tmp_path / "shown")), GRAY)
