"""The optional network for outlines: off unless named, asked on keyframes, refused at start when it is missing or broken."""

import json
import os
import pathlib
import subprocess
import sys

import numpy
import onnx_writer
import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
DEFAULTS = REPOSITORY / "config/default.toml"
sys.path[:0] = [str(REPOSITORY / "hil"), str(REPOSITORY / "tools"), str(REPOSITORY / "tests/replay")]

from plots.overlay import read_masks  # noqa: E402
from sequence_writer import SequenceWriter  # noqa: E402

pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")

WIDTH, HEIGHT, SIDE = 320, 240, 90
FRAMES = 8


def texture(seed: int, width: int, height: int, level: float) -> numpy.ndarray:
    """Blobs three pixels across about a level."""
    rough = numpy.random.default_rng(seed).normal(0.0, 45.0, (height // 3 + 2, width // 3 + 2))
    smooth = numpy.kron(rough, numpy.ones((3, 3)))[:height, :width]
    return numpy.clip(level + smooth, 20, 235)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A square that moves by 5 px a frame before a wall that stays."""
    writer = SequenceWriter(tmp_path_factory.mktemp("scene") / "sequence", width=WIDTH, height=HEIGHT)
    wall, square = texture(1, WIDTH, HEIGHT, 90.0), texture(2, SIDE, SIDE, 140.0)
    random = numpy.random.default_rng(3)
    for frame in range(FRAMES):
        picture = wall.copy()
        left = 60 + 5 * frame
        picture[70 : 70 + SIDE, left : left + SIDE] = square
        writer.add(numpy.clip(picture + random.normal(0.0, 1.0, picture.shape), 0, 255).astype(numpy.uint8))
    return writer.path


@pytest.fixture
def replay(scene, tmp_path):
    def call(*arguments, out="run"):
        done = subprocess.run([PROGRAM, "replay", "--config", DEFAULTS, "--sequence", scene, "--out", tmp_path / out, "--masks",
                               *arguments], capture_output=True, text=True, timeout=300)
        done.folder = tmp_path / out
        return done

    return call


def named(file: pathlib.Path) -> list[str]:
    return ["--set", f'network.file="{file}"']


def network_file(folder: pathlib.Path, content: bytes) -> pathlib.Path:
    file = folder / "outline.onnx"
    file.write_bytes(content)
    return file


def told(run) -> dict | None:
    assert run.returncode == 0, run.stderr
    return json.loads((run.folder / "summary.json").read_text())["network"]


def sharp_areas(run) -> list[int]:
    """Pixels of the outlines that were moved to the picture's edges."""
    return [int(mask.target.sum()) for mask in read_masks(run.folder / "masks.pgms") if mask.sharp]


def test_a_network_is_asked_on_keyframes_and_its_word_counts(replay, tmp_path):
    off = replay(out="off")
    assert told(off) is None
    areas = {"off": sharp_areas(off)}
    assert len(areas["off"]) >= 3
    assert numpy.mean(areas["off"]) == pytest.approx(SIDE**2, rel=0.25)
    for name in ("keeps_the_outline", "sees_background_everywhere"):
        run = replay(*named(network_file(tmp_path, getattr(onnx_writer, name)())), out=name)
        network = told(run)
        areas[name] = sharp_areas(run)
        assert network["times_asked"] == len(areas[name]) and len(network["sha256"]) == 64
    assert numpy.mean(areas["keeps_the_outline"]) == pytest.approx(numpy.mean(areas["off"]), rel=0.1)
    # It does not outvote what the pictures show clearly.
    assert 0.2 * SIDE**2 < numpy.mean(areas["sees_background_everywhere"]) < 0.97 * numpy.mean(areas["off"])


def test_the_same_network_gives_the_same_packets(replay, tmp_path):
    file = network_file(tmp_path, onnx_writer.sees_target_where_it_is_bright())
    runs = [replay(*named(file), out=out) for out in ("one", "two")]
    assert told(runs[0]) == told(runs[1])
    for name in ("bus.ccsds", "masks.pgms"):
        assert (runs[0].folder / name).read_bytes() == (runs[1].folder / name).read_bytes()


# verifies: MSK-05
@pytest.mark.parametrize("content", [None, b"", b"no network", onnx_writer.keeps_the_outline()[:200],
                                     onnx_writer.of_another_shape()], ids=["missing", "empty", "text", "cut", "shape"])
def test_a_missing_or_broken_network_is_refused_before_anything_starts(replay, tmp_path, content):
    file = tmp_path / "outline.onnx"
    if content is not None:
        file.write_bytes(content)
    run = replay(*named(file))
    assert run.returncode == 2
    assert str(file) in run.stderr and "network.file" in run.stderr
    assert not run.folder.exists()
