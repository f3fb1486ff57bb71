"""Levels of 8, 10, 12 and 14 bits in 16-bit pictures are shifted up, and the program says so."""

import json
import struct
import zlib

import numpy
import pytest
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

FRAMES = 4


def with_sbit(file, bits: int) -> None:
    """The chunk sBIT behind the header."""
    octets, chunk = file.read_bytes(), b"sBIT" + bytes([bits])
    file.write_bytes(octets[:33] + struct.pack(">I", 1) + chunk + struct.pack(">I", zlib.crc32(chunk)) + octets[33:])


def sequence(folder, factor: int, sbit: int = 0, suffix: str = ".png") -> SequenceWriter:
    writer = SequenceWriter(folder, suffix)
    for seed in range(FRAMES):
        file = writer.add(textured(seed).astype(numpy.uint16) * factor)
        if sbit:
            with_sbit(file, sbit)
    return writer


def bus(result) -> bytes:
    assert result.status == 0, result.err
    return (result.folder / "bus.ccsds").read_bytes()


@pytest.fixture
def full(replay, tmp_path) -> bytes:
    result = replay(sequence(tmp_path / "full", 256).path, out=tmp_path / "out_full")
    assert "16-bit" not in result.err
    return bus(result)


@pytest.mark.parametrize(("factor", "bits", "sbit", "suffix"), [(1, 8, 0, ".png"), (4, 10, 0, ".png"), (16, 12, 0, ".png"), (64, 14, 0, ".png"), (16, 12, 12, ".png"), (16, 12, 0, ".pgm")])
def test_unshifted_levels_are_found(replay, tmp_path, full, factor, bits, sbit, suffix):
    result = replay(sequence(tmp_path / "low", factor, sbit, suffix).path)
    assert bus(result) == full
    assert f"taken for {bits} bits (--depth-bits says other)" in result.err


def test_the_option_decides_and_is_not_remarked_on(replay, tmp_path, full):
    low = sequence(tmp_path / "low", 16).path
    said = replay(low, "--depth-bits", "12")
    assert bus(said) == full and "--depth-bits" not in said.err
    as_it_is = replay(low, "--depth-bits", "16", out=tmp_path / "dark")
    assert bus(as_it_is) != full
    assert replay(low, "--depth-bits", "11", out=tmp_path / "none").status == 2


@pytest.mark.parametrize("sbit", [12, 16])
def test_levels_that_were_shifted_up_stay(replay, tmp_path, full, sbit):
    assert bus(replay(sequence(tmp_path / "shifted", 256, sbit).path)) == full


def test_dark_pictures_that_say_16_bits_stay(replay, tmp_path):
    dark = replay(sequence(tmp_path / "dark", 16, 16).path)
    assert "taken for" not in dark.err
    assert bus(dark) == bus(replay(sequence(tmp_path / "unsaid", 16).path, "--depth-bits", "16", out=tmp_path / "other"))


def test_levels_beyond_the_depth_are_counted(replay, tmp_path):
    """Five pictures tell the depth: the sixth of eleven is not among them."""
    writer = SequenceWriter(tmp_path / "low")
    for seed in range(11):
        writer.add(textured(seed).astype(numpy.uint16) * (64 if seed == 5 else 16))
    result = replay(writer.path)
    summary = json.loads((result.folder / "summary.json").read_text())
    assert summary["depth_bits"] == 12 and any("1 of 11 pictures hold levels beyond the 12 bits" in warning for warning in summary["warnings"])
