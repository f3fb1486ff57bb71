"""FITS: levels as they are, upright, with the times of its header; a cube is a stack."""

import numpy as np
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.decoding import read_picture
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Options

fits = pytest.importorskip("astropy.io.fits")
LEVELS = np.arange(48, dtype=np.uint16).reshape(6, 8) * 1000


def write(path, pixels=LEVELS, **header):
    part = fits.PrimaryHDU(pixels)
    for name, value in header.items():
        part.header[name.replace("_", "-")] = value
    part.writeto(path)
    return path


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.int16, np.float32])
def test_levels_are_kept_and_turned_upright(tmp_path, kind):
    pixels = (LEVELS // 1000).astype(kind)
    found = read_picture(write(tmp_path / "a.fits", pixels))
    assert found.pixels.dtype == kind and np.array_equal(found.pixels, pixels[::-1]) and "from the bottom up" in found.remark
    found = read_picture(write(tmp_path / "b.fits", pixels, ROWORDER="TOP-DOWN"))
    assert np.array_equal(found.pixels, pixels) and not found.remark


def test_a_folder_has_the_times_of_its_headers(tmp_path):
    for second in range(4):
        write(tmp_path / f"{second}.fit", DATE_OBS=f"2024-05-01T10:00:0{second}.25")
    source = open_source(tmp_path, Options())
    assert np.diff(source.times_ns).tolist() == [10**9] * 3 and source.times_ns[0] % 10**9 == 250_000_000
    assert "DATE-OBS" in source.account.assumed[0] and not source.nominal_time and len(list(source.frames)) == 4


def test_a_cube_is_a_stack_and_a_single_one_is_none(tmp_path):
    source = open_source(write(tmp_path / "cube.fits", np.stack([LEVELS + i for i in range(5)])), Options(rate_hz=10.0))
    frames = list(source.frames)
    assert source.kind == "FITS of 5 pages" and all(np.array_equal(frame.pixels, (LEVELS + i)[::-1]) for i, frame in enumerate(frames))
    with pytest.raises(BadInput, match="found a single picture"):
        open_source(write(tmp_path / "one.fits"), Options())


def test_a_file_without_a_picture_or_cut(tmp_path):
    fits.PrimaryHDU().writeto(tmp_path / "none.fits")
    with pytest.raises(BadInput, match="a FITS file without a picture"):
        read_picture(tmp_path / "none.fits")
    octets = write(tmp_path / "a.fits", np.zeros((99, 99), np.uint16)).read_bytes()
    (tmp_path / "cut.fits").write_bytes(octets[:6000])
    with pytest.raises(BadInput, match="cut.fits: a fits file that can't be read"):
        read_picture(tmp_path / "cut.fits")


def test_dates_in_whole_seconds_are_named_as_what_repeats(tmp_path):
    for i in range(6):
        write(tmp_path / f"o_{i:03d}.fits", DATE_OBS=f"2026-03-01T12:00:{i // 2:02d}")
    source = open_source(tmp_path, Options())
    assert source.nominal_time and source.account.assumed[0].startswith("the times of FITS' DATE-OBS repeat, run back or are missing: one picture a second")
