"""A colour sensor's mosaic in gray pictures is found, told and taken out; --mosaic decides otherwise."""

import json

import numpy
import pytest
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

FRAMES = 4
GAINS = numpy.array([[1.0, 0.75], [0.75, 0.45]])  # RGGB, before a body of one colour
FOUND = "as in the mosaic of a colour sensor"


def with_mosaic(pixels: numpy.ndarray) -> numpy.ndarray:
    height, width = pixels.shape
    return numpy.round(pixels * numpy.tile(GAINS, (height // 2, width // 2))).astype(pixels.dtype)


def levelled(pixels: numpy.ndarray) -> numpy.ndarray:
    """1-2-1 along rows and columns, mirrored at the border, rounded once."""
    around = numpy.pad(pixels.astype(numpy.uint64), 1, mode="reflect")
    along = around[:, :-2] + 2 * around[:, 1:-1] + around[:, 2:]
    return ((along[:-2] + 2 * along[1:-1] + along[2:] + 8) // 16).astype(pixels.dtype)


def sequence(folder, change=lambda pixels: pixels, kind=numpy.uint8, suffix=".png"):
    writer = SequenceWriter(folder, suffix)
    for seed in range(FRAMES):
        writer.add(change(textured(seed).astype(kind) * (1 if kind == numpy.uint8 else 257)))
    return writer.path


def bus(result) -> bytes:
    assert result.status == 0, result.err
    return (result.folder / "bus.ccsds").read_bytes()


@pytest.mark.parametrize(("kind", "suffix"), [(numpy.uint8, ".png"), (numpy.uint16, ".pgm")])
def test_it_is_told_and_levelled(replay, tmp_path, kind, suffix):
    found = replay(sequence(tmp_path / "raw", with_mosaic, kind, suffix))
    summary = json.loads((found.folder / "summary.json").read_text())
    assert FOUND in found.err and any(FOUND in warning for warning in summary["warnings"]) and summary["mosaic"] is True
    by_hand = replay(sequence(tmp_path / "levelled", lambda pixels: levelled(with_mosaic(pixels)), kind, suffix), out=tmp_path / "by_hand")
    assert FOUND not in by_hand.err and bus(found) == bus(by_hand)


def test_the_option_decides(replay, tmp_path):
    raw = sequence(tmp_path / "raw", with_mosaic)
    kept = replay(raw, "--mosaic", "keep")
    assert "it is kept, as --mosaic says" in kept.err and bus(kept) != bus(replay(raw, out=tmp_path / "found"))
    gray = sequence(tmp_path / "gray")
    plain = replay(gray, out=tmp_path / "plain")
    assert FOUND not in plain.err
    assert bus(replay(gray, "--mosaic", "level", out=tmp_path / "asked")) != bus(plain)
    assert replay(gray, "--mosaic", "maybe", out=tmp_path / "none").status == 2


def test_it_is_not_found_where_one_picture_has_none(replay, tmp_path):
    writer = SequenceWriter(tmp_path / "mixed")
    for seed in range(FRAMES):
        writer.add(textured(seed) if seed == 1 else with_mosaic(textured(seed)))
    assert FOUND not in replay(writer.path).err
