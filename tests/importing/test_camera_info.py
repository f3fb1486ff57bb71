"""CameraInfo of a part of the sensor, of binned pixels, and of what does not fit together; pixels that are no squares."""

import fractions

import made_sources as sources
import numpy as np
import pytest
from PIL import Image

NEEDED = (888.9, 888.9, 319.5, 239.5)
PICTURE = np.full((480, 640), 90, np.uint8)


def info(sensor, focal_px, centre, binning=0, roi=(0, 0, 0, 0), **more):
    """@param roi  x, y, width, height"""
    return {"width": sensor[0], "height": sensor[1], "distortion_model": "plumb_bob", "d": [0.0] * 5, "binning_x": binning, "binning_y": binning,
            "k": [focal_px, 0, centre[0], 0, focal_px, centre[1], 0, 0, 1], "roi": dict(zip(("x_offset", "y_offset", "width", "height"), roi))} | more


# verifies: GND-03
@pytest.mark.parametrize("message", [
    info((1280, 960), 888.9, (600.5, 400.5), roi=(281, 161, 640, 480)),
    info((1280, 1024), 888.9, (600.5, 400.5), roi=(281, 161, 640, 480)),
    info((1280, 960), 1777.8, (639.5, 479.5), binning=2),
    info((1400, 1100), 1777.8, (681.5, 541.5), binning=2, roi=(42, 62, 1280, 960)),
    info((1322, 1022), 1777.8, (681.5, 541.5), binning=2, roi=(42, 62, 0, 0)),
], ids=["region", "region of another shape", "binning", "both", "region to the sensor's end"])
def test_region_and_binning_move_the_principal_point(message):
    from polhode_ground.importing.camera_info import lens_of_info
    lens = lens_of_info(message, False, "/info")
    assert lens.intrinsics_px == pytest.approx(NEEDED) and (lens.width_px, lens.height_px) == (640, 480)
    assert "roi" in lens.notes[0] and "intrinsics 888.9" in lens.notes[0]


def test_rectified_pictures_have_the_numbers_of_p():
    from polhode_ground.importing.camera_info import lens_of_info
    message = info((1280, 960), 1.0, (2.0, 3.0), roi=(281, 161, 640, 480), p=[888.9, 0, 600.5, 0, 0, 888.9, 400.5, 0, 0, 0, 1, 0], d=[-0.2, 0, 0, 0, 0])
    lens = lens_of_info(message, True, "/info")
    assert lens.intrinsics_px == pytest.approx(NEEDED) and not any(lens.coefficients)


@pytest.mark.parametrize(("message", "says"), [
    (info((2560, 1920), 888.9, (319.5, 239.5), binning=4), "which of them K is of is not clear"),
    (info((1280, 960), 888.9, (319.5, 239.5), roi=(281, 161, 640, 480)), "which of them K is of is not clear"),
    (info((640, 480), 888.9, (319.5, 239.5), roi=(281, 161, 640, 480)), "the region is not within the sensor"),
    (info((1280, 960), 888.9, (639.5, 479.5), k=[1.0]), "K has 1 numbers, needed are 9"),
], ids=["K of the binned picture", "K of the region", "size of the region", "no matrix"])
def test_what_does_not_fit_together_is_refused(message, says):
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.camera_info import lens_of_info
    with pytest.raises(BadInput, match=says):
        lens_of_info(message, False, "/info")


def test_pictures_of_another_size_than_region_and_binning_make_are_refused():
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.camera_info import lens_of_info
    from polhode_ground.importing.lens import scaled_to
    lens = lens_of_info(info((1280, 960), 888.9, (639.5, 479.5), binning=2), False, "/info")
    assert scaled_to(lens, 641, 480, "/info")[0].width_px == 641  # a driver that rounds up
    with pytest.raises(BadInput, match="binning 2x2 of 1280x960 makes pictures of 640x480, but they are 320x240: give --intrinsics"):
        scaled_to(lens, 320, 240, "/info")


def write_bag(path, messages, topic="/cam/image_raw"):
    store, written = sources.ros_types(2), []
    for index, message in enumerate(messages):
        one = sources.info_message(store, message["width"], message["height"], message["k"], message["d"])
        one.binning_x = one.binning_y = message["binning_x"]
        for name, value in message["roi"].items():
            setattr(one.roi, name, value)
        written += [("/cam/camera_info", index + 1, one), (topic, index + 1, sources.image_message(store, PICTURE, (index + 1) * sources.NS))]
    sources.write_bag(path, 2, written)


def test_a_bag_whose_numbers_contradict_needs_others(imported, refused, tmp_path):
    write_bag(tmp_path / "bag", [info((2560, 1920), 888.9, (319.5, 239.5), binning=4)] * 2)
    assert "binning 4x4 of 2560x1920" in refused(tmp_path / "bag")
    sequence, _ = imported(tmp_path / "bag", "--intrinsics", "888.9,888.9,319.5,239.5")
    assert tuple(sequence.camera.intrinsics_px) == NEEDED


def test_a_camera_without_calibration_is_no_lens(refused, tmp_path):
    write_bag(tmp_path / "bag", [info((640, 480), 0.0, (0.0, 0.0))])
    assert "/cam/camera_info is of a camera without calibration: give --intrinsics FILE" in refused(tmp_path / "bag")


def test_a_camera_that_zooms_is_told(imported, tmp_path):
    write_bag(tmp_path / "bag", [info((640, 480), focal_px, (319.5, 239.5)) for focal_px in (888.9, 888.9, 1000.0)], "/cam/rect/image")
    sequence, out = imported(tmp_path / "bag", "--intrinsics", "888.9,888.9,319.5,239.5")
    assert "camera_info changes: 1 of 3 messages differ from the first" in out


def test_the_shape_of_pixels_is_the_container_s(imported, tmp_path):
    import av
    with av.open(str(tmp_path / "clip.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=1)
        stream.width, stream.height, stream.pix_fmt = 480, 480, "yuv420p"
        stream.codec_context.sample_aspect_ratio = fractions.Fraction(4, 3)
        for number in range(2):
            picture = av.VideoFrame.from_ndarray(PICTURE[:, :480].copy(), format="gray").reformat(format="yuv420p")
            picture.pts = number
            container.mux(stream.encode(picture))
        container.mux(stream.encode(None))
    (tmp_path / "square.yaml").write_text("image_width: 640\nimage_height: 480\ncamera_matrix: [[888, 0, 319.5], [0, 888, 239.5], [0, 0, 1]]\n")
    sequence, out = imported(tmp_path / "clip.mp4", "--intrinsics", tmp_path / "square.yaml", name="SQUARE")
    assert sequence.camera.intrinsics_px.tolist() == [666, 888, 239.5, 239.5]  # of the stretched picture of 640x480
    assert "intrinsics scaled by 0.75 and 1, by the shape of the pixels" in out and "1.333 times as wide as high, and so do the intrinsics" in out
    sequence, out = imported(tmp_path / "clip.mp4", "--intrinsics", "888,888,239.5,239.5", name="NUMBERS")
    assert "but fu / fv of the intrinsics is 1 in place of 0.75: the intrinsics are followed" in out


def test_the_shape_of_pixels_is_the_picture_s(tmp_path):
    from polhode_ground.importing.pictures import pixel_aspect
    from polhode_ground.importing.pixel_shape import aspect_of
    from polhode_ground.importing.writing import centred, write_sensor
    for name, density, aspect in (("a.png", (100, 75), 3 / 4), ("b.jpg", (75, 75), 1.0), ("c.jpg", (75, 100), 4 / 3)):
        Image.fromarray(PICTURE).save(tmp_path / name, dpi=density)
        with Image.open(tmp_path / name) as picture:
            assert pixel_aspect(picture) == pytest.approx(aspect, rel=1e-3), name
    sensor = tmp_path / "sensor.yaml"
    write_sensor(sensor, centred(480, 480), 1.0, "made", "auto", 4 / 3)
    assert aspect_of(sensor) == pytest.approx(4 / 3)
    write_sensor(sensor, centred(480, 480), 1.0, "made", "auto")
    assert aspect_of(sensor) == 1
    sensor.write_text(sensor.read_text().replace("intrinsics: auto", "intrinsics: [600, 800, 1, 2]"))
    assert aspect_of(sensor) == pytest.approx(4 / 3)


def test_a_focal_length_of_stretched_pixels_is_two(tmp_path):
    """The pictures are made square for the estimate, and its one focal length is taken back to both axes."""
    from polhode_ground.importing import focal, pixel_shape
    from polhode_ground.importing.writing import centred, write_sensor
    Image.fromarray(PICTURE[:, :480].copy()).save(tmp_path / "1.png")
    pixel_shape.stretch(tmp_path, ["1.png"], pixel_shape.stretch_of(4 / 3))
    with Image.open(tmp_path / "1.png") as picture:
        assert picture.size == (640, 480)
    write_sensor(tmp_path / "sensor.yaml", centred(480, 480), 1.0, "made", "auto", 4 / 3)
    camera = type("Camera", (), {"width_px": 480, "height_px": 480, "intrinsics_px": (1, 1, 239.5, 239.5)})
    focal.write(tmp_path / "sensor.yaml", camera, {"placed": 9, "points": 5, "focal_px": 666.0, "sigma_px": 4.0, "residual_px": 0.4}, 10)
    text = (tmp_path / "sensor.yaml").read_text()
    assert "intrinsics: [666, 888, 239.5, 239.5]" in text and "pixel_aspect: 1.3333" in text


@pytest.mark.parametrize("before", ["auto  # fu, fv, cu, cv [px]; the centre of the top-left pixel is (0, 0)", "[1, 1, 2, 2]", "\n- 1\n- 1\n- 2\n- 2", "[1, 1, 2, 2] # old"])
def test_an_estimate_leaves_a_file_that_can_be_read_and_estimated_again(before):
    import yaml
    from polhode_ground.importing.focal import with_intrinsics
    text = f"sensor_type: camera\nintrinsics: {before}\ndistortion_model: radial-tangential\n"
    for focal in (300, 400):
        text = with_intrinsics(text, f"focal length estimated: {focal}", f"[{focal}, {focal}, 3, 4]", 1.0)
        values = yaml.safe_load(text)
        assert values == {"sensor_type": "camera", "sigma_focal_px": 1.0, "intrinsics": [focal, focal, 3, 4], "distortion_model": "radial-tangential"}
        assert text.count("#") == 2
