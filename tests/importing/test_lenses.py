"""Lenses from every kind of calibration file, other sizes, other distortions, and COLMAP's cameras."""


import subprocess

import cv2
import made_sources as sources
import numpy as np
import pytest
from made_sources import REPOSITORY

MATRIX = np.array([[500.0, 0, 310], [0, 505, 230], [0, 0, 1]])
RADTAN5 = [-0.2, 0.08, 0.001, -0.0005, 0.02]


def write_opencv(path, distortion=RADTAN5[:4]):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", MATRIX)
    storage.write("distortion_coefficients", np.array([distortion]))
    storage.release()


KALIBR = """cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.2, 0.08, 0.001, -0.0005]
  distortion_model: radtan
  intrinsics: [500.0, 505.0, 310.0, 230.0]
  resolution: [640, 480]
  rostopic: /cam0
cam1: {camera_model: cylinder, intrinsics: [1, 2, 3, 4, 5]}
"""
ROS = """image_width: 640
image_height: 480
camera_name: c
camera_matrix: {rows: 3, cols: 3, data: [500, 0, 310, 0, 505, 230, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.2, 0.08, 0.001, -0.0005, 0]}
"""


PRINTED = """width: 640
height: 480
distortion_model: plumb_bob
D: [-0.2, 0.08, 0.001, -0.0005, 0.0]
K: [500, 0, 310, 0, 505, 230, 0, 0, 1]
---
"""
WRITTEN = {"kalibr.yaml": KALIBR, "ros.yaml": ROS, "printed.yaml": PRINTED}


@pytest.mark.parametrize("name", ["calib.xml", "calib.yml", "calib.json", *WRITTEN])
def test_files_of_all_kinds_say_the_same(tmp_path, name):
    from polhode_ground.importing.calibration_files import read_lens
    if name.startswith("calib"):
        write_opencv(tmp_path / name)
    else:
        (tmp_path / name).write_text(WRITTEN[name])
    lens = read_lens(tmp_path / name)
    assert lens.intrinsics_px == (500, 505, 310, 230) and lens.native
    assert (lens.width_px, lens.height_px) == (640, 480) and lens.coefficients[:4] == tuple(RADTAN5[:4])


def test_a_file_without_size_or_model_says_what_it_is_taken_for(tmp_path):
    from polhode_ground.importing.calibration_files import read_lens
    np.savez(tmp_path / "calib.npz", mtx=MATRIX, dist=np.array([RADTAN5[:4]]))
    lens = read_lens(tmp_path / "calib.npz")
    assert lens.intrinsics_px == (500, 505, 310, 230) and lens.width_px == 0
    assert "names no distortion model" in lens.notes[0] and "tells no size of pictures" in lens.notes[1]


@pytest.mark.parametrize(("text", "camera", "says"), [
    (KALIBR, "cam1", "camera_model 'cylinder', allowed are pinhole, omni, ds, eucm"),
    (KALIBR, "cam7", "camera 'cam7' is not in it, it has cam0, cam1"),
    ("a: 1\n", "cam0", "holds neither intrinsics (Kalibr, EuRoC) nor a camera matrix"),
    ("[", "cam0", "not YAML"),
    (KALIBR.replace("radtan", "mirror"), "cam0", "distortion model 'mirror', allowed are"),
    (KALIBR.replace("radtan", "fov"), "cam0", "4 distortion coefficients for 'fov', allowed are 1"),
    (KALIBR.replace("radtan", "none"), "cam0", "distortion model 'none', but coefficients -0.2, 0.08"),
    (KALIBR.replace("pinhole", "omni").replace("radtan", "equidistant"), "cam0", "'omni' with distortion_model 'equidistant', allowed is radtan or none"),
    ("camera_matrix: [[500, 0, 0], [0, 505, 0], [310, 230, 1]]\n", "cam0", "as in MATLAB"),
    ("camera_matrix: [[500, 3, 310], [0, 505, 230], [0, 0, 1]]\n", "cam0", "a skew of 3 px, allowed is up to 0.5"),
    (KALIBR.replace("[500.0, 505.0", "[-500.0, 505.0"), "cam0", "focal lengths must be positive"),
    (KALIBR.replace("0.001, -0.0005", "0.001"), "cam0", "3 distortion coefficients"),
])
def test_files_that_cannot_be_used(tmp_path, text, camera, says):
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.calibration_files import read_lens
    (tmp_path / "calibration.yaml").write_text(text)
    with pytest.raises(BadInput, match="calibration.yaml") as caught:
        read_lens(tmp_path / "calibration.yaml", camera)
    assert says in str(caught.value)


def test_a_lens_beyond_the_programs_range_is_none_of_its_own():
    from polhode_ground.importing.lens import lens_of
    assert lens_of(640, 480, (5e4, 5e4, 320, 240), "radtan", (-9, 0, 0, 0), "file").native
    assert not lens_of(640, 480, (5e4, 5e4, 320, 240), "radtan", (-300, 0, 0, 0), "file").native


# verifies: GND-03
def test_another_camera_of_the_chain_is_named_where_its_size_fits(tmp_path):
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.calibration_files import read_lens
    from polhode_ground.importing.lens import scaled_to
    second = KALIBR.split("cam1")[0].replace("cam0", "cam1").replace("[640, 480]", "[752, 480]")
    (tmp_path / "chain.yaml").write_text(KALIBR.split("cam1")[0] + second)
    first, other = (read_lens(tmp_path / "chain.yaml", camera) for camera in ("cam0", "cam1"))
    with pytest.raises(BadInput, match="cam0 is calibrated for 640x480, but the pictures are 752x480: cam1 of the same file is of this size: --camera cam1 takes it"):
        scaled_to(first, 752, 480, "chain.yaml")
    with pytest.raises(BadInput, match="cam1 is calibrated for 752x480, but the pictures are 800x800: not the same shape, cropped"):
        scaled_to(other, 800, 800, "chain.yaml")
    assert scaled_to(other, 752, 480, "chain.yaml")[1] == ""
    (tmp_path / "chain.yaml").write_text(KALIBR.split("cam1")[0] + second.replace("752, 480", "320, 240"))
    lens, said = scaled_to(read_lens(tmp_path / "chain.yaml"), 320, 240, "chain.yaml")
    assert lens.intrinsics_px[0] == 250 and said.endswith("intrinsics scaled by 0.5; cam1 of the same file is of this size: --camera cam1 takes it")


def test_a_calibration_of_another_size_is_scaled_and_one_of_another_shape_refused(imported, refused, tmp_path):
    sources.write_pictures(tmp_path / "small", [np.full((240, 320), 90, np.uint8)] * 2, ["1.png", "2.png"])
    sources.write_pictures(tmp_path / "upright", [np.full((640, 480), 90, np.uint8)] * 2, ["1.png", "2.png"])
    (tmp_path / "kalibr.yaml").write_text(KALIBR)
    assert "width and height are exchanged: in the calibration, or by pictures that are turned by 90 deg" in refused(tmp_path / "upright", "--intrinsics", tmp_path / "kalibr.yaml")
    sequence, out = imported(tmp_path / "small", "--intrinsics", tmp_path / "kalibr.yaml")
    assert sequence.camera.intrinsics_px.tolist() == [250, 252.5, 154.75, 114.75]
    assert "calibrated for 640x480, but the pictures are 320x240: intrinsics scaled by 0.5" in out


def dotted(points_px):
    """A picture of small blobs, each centred where it is asked for."""
    v, u = np.mgrid[0:480, 0:640]
    picture = np.zeros((480, 640))
    for x, y in points_px:
        picture += 220 * np.exp(-((u - x) ** 2 + (v - y) ** 2) / 8)
    return np.clip(picture, 0, 255).astype(np.uint8)


def blob_centres(picture):
    _, _, _, centres = cv2.connectedComponentsWithStats((picture > 40).astype(np.uint8))
    count, labels = cv2.connectedComponents((picture > 40).astype(np.uint8))
    v, u = np.mgrid[0:picture.shape[0], 0:picture.shape[1]]
    return np.array([[np.average(axis[labels == i], weights=picture[labels == i]) for axis in (u, v)] for i in range(1, count)])


@pytest.mark.parametrize(("model", "coefficients"), [("plumb_bob", RADTAN5), ("equidistant", [0.05, -0.01, 0.002, 0.0])])
def test_other_distortions_are_taken_out_of_the_pictures(imported, tmp_path, model, coefficients):
    """Points of a known place come to lie where the new intrinsics, without distortion, say."""
    places = np.array([[x, y, 1.0] for x in (-0.4, 0.0, 0.4) for y in (-0.3, 0.0, 0.3)])
    if model == "equidistant":
        seen, _ = cv2.fisheye.projectPoints(places[:, None], np.zeros(3), np.zeros(3), MATRIX, np.array(coefficients))
    else:
        seen, _ = cv2.projectPoints(places, np.zeros(3), np.zeros(3), MATRIX, np.array(coefficients))
    sources.write_pictures(tmp_path / "photos", [dotted(seen.reshape(-1, 2))] * 2, ["1.png", "2.png"])
    (tmp_path / "ros.yaml").write_text(f"image_width: 640\nimage_height: 480\ncamera_matrix: {{data: {MATRIX.ravel().tolist()}}}\n"
                                       f"distortion_model: {model}\ndistortion_coefficients: {{data: {coefficients}}}\n")
    sequence, out = imported(tmp_path / "photos", "--intrinsics", tmp_path / "ros.yaml")
    assert "the pictures are undistorted" in out and not sequence.camera.distortion.any()
    expected, found = sequence.camera.project(places), blob_centres(sequence.read_gray(0))
    assert len(found) == len(places)
    assert max(np.linalg.norm(found - one, axis=1).min() for one in expected) < 0.1  # blobs are resampled, not drawn anew


@pytest.mark.parametrize(("model", "params", "native", "expected"), [
    ("SIMPLE_PINHOLE", [500, 320, 240], True, (500, 500, 319.5, 239.5)),
    ("PINHOLE", [500, 505, 320, 240], True, (500, 505, 319.5, 239.5)),
    ("SIMPLE_RADIAL", [500, 320, 240, -0.1], True, (500, 500, 319.5, 239.5)),
    ("RADIAL", [500, 320, 240, -0.1, 0.02], True, (500, 500, 319.5, 239.5)),
    ("OPENCV", [500, 505, 320, 240, -0.1, 0.02, 0.001, 0.0], True, (500, 505, 319.5, 239.5)),
    ("FULL_OPENCV", [500, 505, 320, 240, -0.1, 0.02, 0, 0, 0.01, 0, 0, 0], False, (500, 505, 319.5, 239.5)),
    ("OPENCV_FISHEYE", [500, 505, 320, 240, -0.1, 0.02, 0, 0], False, (500, 505, 319.5, 239.5)),
    ("RADIAL_FISHEYE", [500, 320, 240, -0.1, 0.02], False, (500, 500, 319.5, 239.5)),
])
def test_cameras_of_colmap(model, params, native, expected):
    from polhode_ground.importing.colmap_lens import lens_of_camera
    lens = lens_of_camera({"model": model, "width": 640, "height": 480, "params": params}, "project")
    assert lens.native is native and lens.intrinsics_px == expected
    if "RADIAL" in model or "OPENCV" in model:
        assert lens.coefficients[0] == -0.1


def test_a_camera_for_each_picture_becomes_one():
    from polhode_ground.importing.colmap_lens import with_one_camera
    from polhode_ground.importing.source import Account
    cameras = {str(i): {"model": "SIMPLE_RADIAL", "width": 640, "height": 480, "params": [f, 320, 240, 0.01]} for i, f in enumerate((890, 900, 905))}
    images = [{"name": f"{i}.png", "camera": str(i)} for i in range(3)]
    account = Account()
    joined = with_one_camera({"cameras": cameras, "images": images}, account)
    number, = {image["camera"] for image in joined["images"]}
    assert joined["cameras"][number]["params"] == [900, 320, 240, 0.01]
    assert "3 cameras for 3 pictures" in account.assumed[0] and "up to 1.1 %" in account.assumed[0]
    two = {"cameras": cameras, "images": [{"name": f"{i}.png", "camera": str(i // 4)} for i in range(8)]}
    assert with_one_camera(two, Account()) is two  # a pair of cameras stays a pair


@pytest.mark.further
@pytest.mark.skipif(not (REPOSITORY / ".venv-colmap/bin/python3").exists(), reason="COLMAP is not set up: tools/setup.sh colmap")
@pytest.mark.parametrize("binary", [True, False], ids=["binary", "text"])
def test_a_project_of_colmap(imported, sample, tmp_path, binary):
    names = [f"{i}.png" for i in (8, 9, 10)]
    sources.write_pictures(tmp_path / "project/images", [sample.read_gray(i) for i in range(3)], names)
    place = tmp_path / "project/sparse/0"
    place.mkdir(parents=True)
    (place / "cameras.txt").write_text("1 RADIAL 640 480 888.9 320 240 0.01 0.0\n2 PINHOLE 640 480 1 1 320 240\n")
    (place / "images.txt").write_text("".join(f"{i} 1 0 0 0 0 0 {i} 1 {name}\n\n" for i, name in enumerate(names, 1)) + "9 1 0 0 0 0 0 1 2 other.png\n\n")
    (place / "points3D.txt").write_text("")
    if binary:
        script = f"import pycolmap; pycolmap.Reconstruction('{place}').write_binary('{place}')"
        subprocess.run([REPOSITORY / ".venv-colmap/bin/python3", "-c", script], check=True)
        for name in ("cameras", "images", "points3D"):
            (place / f"{name}.txt").unlink()
    sequence, out = imported(tmp_path / "project", "--rate-hz", 2)
    assert sequence.camera.intrinsics_px.tolist() == [888.9, 888.9, 319.5, 239.5] and sequence.camera.distortion[0] == 0.01
    assert all(np.array_equal(sequence.read_gray(i), sample.read_gray(i)) for i in range(3))
    assert "COLMAP project, 3 pictures, camera RADIAL" in out and "1 frames: taken by another camera" in out
