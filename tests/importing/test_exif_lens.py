"""The focal length that EXIF tells, of pictures that were resized, turned or cropped since."""

import made_sources as sources
import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.pictures import exif_lens

FOCAL_PX = 888.89  # 8.8889 mm at 100 pixels per mm, of 640x480


def write(folder, wide, high, orientation=None, **fields):
    numbers = {"focal_mm": 0x920A, "plane_x": 0xA20E, "plane_unit": 0xA210, "focal_35mm": 0xA405, "width": 0xA002, "height": 0xA003, "zoom": 0xA404}
    exif = Image.Exif()
    exif.get_ifd(0x8769).update({numbers[name]: value for name, value in fields.items()})
    if orientation:
        exif[0x0112] = orientation
    rows = np.add.outer(np.arange(high), np.arange(wide))
    sources.write_pictures(folder, [np.uint8((rows + 9 * i) // 8 % 251) for i in range(3)], [f"{i}.jpg" for i in range(3)], lambda _: exif)
    return folder


PLANE = {"focal_mm": 8.8889, "plane_x": 100.0, "plane_unit": 4}
TAKEN = {"width": 640, "height": 480}


# verifies: GND-03
@pytest.mark.parametrize(("size", "fields", "focal_px"), [
    ((640, 480), {**PLANE, **TAKEN}, FOCAL_PX), ((320, 240), {**PLANE, **TAKEN}, FOCAL_PX / 2), ((213, 160), {**PLANE, **TAKEN}, FOCAL_PX / 3),
    ((640, 480), PLANE, FOCAL_PX), ((480, 640), {**PLANE, **TAKEN}, FOCAL_PX), ((240, 320), {**PLANE, **TAKEN}, FOCAL_PX / 2),
    ((640, 480), {"focal_35mm": 48}, 48 / 43.27 * 800), ((320, 240), {"focal_35mm": 48, **TAKEN}, 48 / 43.27 * 400)])
def test_the_focal_length_follows_the_pictures_size(tmp_path, imported, size, fields, focal_px):
    sequence, out = imported(write(tmp_path / "photos", *size, **fields))
    assert np.allclose(sequence.camera.intrinsics_px[:2], focal_px, rtol=2e-3)
    assert ("EXIF is of a picture of 640x480, which was resized by 0." in out) == ("width" in fields and 640 not in size)


def test_an_orientation_is_no_crop(tmp_path, imported):
    sequence, _ = imported(write(tmp_path / "photos", 320, 240, orientation=6, **PLANE, **TAKEN))
    assert (sequence.camera.width_px, sequence.camera.height_px) == (240, 320) and np.allclose(sequence.camera.intrinsics_px[:2], FOCAL_PX / 2)


# verifies: GND-03
@pytest.mark.parametrize("fields", [PLANE, {"focal_35mm": 48}])
def test_a_cropped_picture_needs_a_calibration(tmp_path, imported, refused, fields):
    place = write(tmp_path / "photos", 400, 400, **fields, **TAKEN)
    assert "EXIF of 0.jpg is of a picture of 640x480, but this one has 400x400, another shape: it was cropped" in refused(place)
    sequence, _ = imported(place, "--intrinsics", "500,500,199.5,199.5")
    assert sequence.camera.intrinsics_px[0] == 500


# verifies: GND-03
@pytest.mark.parametrize(("zoom", "more", "focal_px"), [
    (2.5, {}, 2.5 * FOCAL_PX), (2.5, {"focal_35mm": 48}, 2.5 * FOCAL_PX), (0.0, {}, FOCAL_PX), (1.0, {"focal_35mm": 48}, 48 / 43.27 * 800)])
def test_a_digital_zoom_is_in_the_focal_length(tmp_path, zoom, more, focal_px):
    lens, how = exif_lens(write(tmp_path / "photos", 640, 480, zoom=zoom, **PLANE, **TAKEN, **more) / "0.jpg")
    assert np.allclose(lens.intrinsics_px[:2], focal_px, rtol=2e-3) and (", digital zoom 2.5" in how) == (zoom == 2.5)


@pytest.mark.parametrize(("size", "fields", "says"), [
    ((640, 480), {"focal_35mm": 48, "zoom": 2.0}, "the focal length is 887 px or 1775 px; give --intrinsics"), ((640, 480), {**PLANE, "zoom": 0.5}, "allowed is at least 1"),
    ((320, 240), {**PLANE, "zoom": 2.0}, "smaller by as much: it was cropped or resized")])
def test_a_digital_zoom_that_is_not_clear_needs_a_calibration(tmp_path, size, fields, says):
    with pytest.raises(BadInput, match=says):
        exif_lens(write(tmp_path / "photos", *size, **fields, **TAKEN) / "0.jpg")
