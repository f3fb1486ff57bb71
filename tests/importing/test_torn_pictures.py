"""A picture of which a part is missing costs itself, whatever is done with the others."""

import io

import made_sources as sources
import numpy as np
import pytest
from PIL import Image


def octets(pixels, **options):
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "JPEG", quality=90, **options)
    return stream.getvalue()


@pytest.fixture(scope="module")
def picture():
    return np.random.default_rng(1).integers(0, 255, (120, 160), dtype=np.uint8)


def read(tmp_path, data, name="1.jpg"):
    from polhode_ground.importing.decoding import read_picture
    (tmp_path / name).write_bytes(data)
    return read_picture(tmp_path / name).pixels


@pytest.mark.parametrize("change", [
    lambda data: data[:-2], lambda data: data[:-1], lambda data: data + b"\0" * 1000, lambda data: data + b"a remark behind the end",
    lambda data: data[:-2] + b"\0" * 500 + data[-2:], lambda data: data[:-2] + b"abc" + data[-2:],
], ids=["no end marker", "half an end marker", "zeros behind", "text behind", "filled up", "a few stray octets"])
def test_a_jpeg_of_which_all_is_there_is_read(tmp_path, picture, change):
    data = octets(picture)
    assert np.array_equal(read(tmp_path, change(data)), read(tmp_path, data))


@pytest.mark.parametrize("change", [
    lambda data: data[:len(data) // 2], lambda data: data[:len(data) // 2] + b"\xff\xd9", lambda data: data[:-40], lambda data: data[:300], lambda data: b"",
    lambda data: data[:len(data) // 2] + data[len(data) // 2 + 2000:],
], ids=["half", "half with an end marker", "the last blocks", "the header", "nothing", "a hole"])
def test_a_jpeg_of_which_a_part_is_missing_is_not(tmp_path, picture, change):
    from polhode_ground.common.errors import BadInput
    with pytest.raises(BadInput, match="1.jpg"):
        read(tmp_path, change(octets(picture)))


def test_a_jpeg_in_scans_needs_its_end(tmp_path, picture):
    from polhode_ground.common.errors import BadInput
    data = octets(picture, progressive=True)
    assert read(tmp_path, data).shape == picture.shape
    with pytest.raises(BadInput, match="its end is missing, and maybe whole scans"):
        read(tmp_path, data[:-2])


# verifies: GND-03
@pytest.mark.parametrize("coefficients", ["[0, 0, 0, 0, 0]", "[-0.1, 0.01, 0, 0, 0.02]"], ids=["copied", "undistorted"])
def test_torn_pictures_are_left_out_and_counted(imported, picture, tmp_path, coefficients):
    names = [f"{i}.jpg" for i in range(4)] + ["4.png", "5.tif", "6.jpg"]
    sources.write_pictures(tmp_path / "photos", [picture] * 7, names)
    for name, kept in (("1.jpg", 0.5), ("4.png", 0.5), ("5.tif", 0.5), ("6.jpg", 0.0)):
        data = (tmp_path / "photos" / name).read_bytes()
        (tmp_path / "photos" / name).write_bytes(data[:int(kept * len(data))])
    (tmp_path / "lens.yaml").write_text("image_width: 160\nimage_height: 120\ncamera_matrix: [[200, 0, 79.5], [0, 200, 59.5], [0, 0, 1]]\n"
                                        f"distortion_coefficients: {coefficients}\n")
    sequence, out = imported(tmp_path / "photos", "--rate-hz", 1, "--allow-loss", "--intrinsics", tmp_path / "lens.yaml", name="SEQ")
    assert sequence.timestamp_ns.tolist() == [0, 2 * sources.NS, 3 * sources.NS]
    assert "4 frames: picture can't be read" in out
