"""Calibrations of other tools, under other names and in other encodings, come out the same or are refused for the right reason."""

import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.arguments import lens_of_numbers
from polhode_ground.importing.calibration_files import read_lens

SIZE = "image_width: 640\nimage_height: 480\n"
MATRIX = "camera_matrix: [[500.0, 0, 310], [0, 505, 230], [0, 0, 1]]\n"
TABLE = "{fx: 500.0, fy: 505.0, cx: 310, cy: 230}"
FOUR = "[-0.2, 0.08, 0.001, -0.0005]"
SINGLY = "k1: -0.2\nk2: 0.08\np1: 0.001\np2: -0.0005\n"
CAMODOCAL = "%YAML:1.0\n---\nmodel_type: {}\n" + SIZE + "distortion_parameters: {{k1: -0.2, k2: 0.08, p1: 0.001, p2: -0.0005}}\n"


def lens_of_file(tmp_path, text, name="calibration.yaml"):
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_lens(tmp_path / name)


@pytest.mark.parametrize("text", [
    *(f"{SIZE}{MATRIX}{key}: {FOUR}\n" for key in ("distortion", "dist_coefs", "distCoef", "dist_coeffs", "distortionCoefficients", "D")),
    SIZE + MATRIX + "radial_distortion: [-0.2, 0.08]\ntangential_distortion: [0.001, -0.0005]\n",
    f"camera: {{image_width: 640, image_height: 480, fx: 500, fy: 505, cx: 310, cy: 230, D: {FOUR}}}\n",
    SIZE + MATRIX + SINGLY, SIZE + MATRIX + "distortion: {k1: -0.2, k2: 0.08, p1: 0.001, p2: -0.0005}\n",
    f"image_size: {{width: 640, height: 480}}\ncamera_matrix: {TABLE}\ndist: {FOUR}\n",
    f"img_shape: [480, 640, 3]\nmtx: [500, 0, 310, 0, 505, 230, 0, 0, 1]\ndist: {FOUR}\n",
    f"{SIZE}fx: 500\nfy: 505\ncx: 310\ncy: 230\n{SINGLY}",
    "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera.fx: 500\nCamera.fy: 505\nCamera.cx: 310\nCamera.cy: 230\nCamera.width: 640\nCamera.height: 480\n"
    + "".join(f"Camera.{line}\n" for line in SINGLY.splitlines()),
    CAMODOCAL.format("PINHOLE") + f"projection_parameters: {TABLE}\n",
    f"{{'lensmodel': 'LENSMODEL_OPENCV4', # of mrcal\n'intrinsics': [500, 505, 310, 230, {FOUR[1:-1]}], 'imagersize': [640, 480],}}",
    '{"FocalLength": [500, 505], "PrincipalPoint": [311, 231], "ImageSize": [480, 640], "RadialDistortion": [-0.2, 0.08],'
    ' "TangentialDistortion": [0.001, -0.0005], "K": [[1]]}',
    f'{{"fl_x": 500, "fl_y": 505, "cx": 310.5, "cy": 230.5, "w": 640, "h": 480, "camera_model": "OPENCV", "coeffs": {FOUR}}}',
    f'{{"width": 640, "height": 480, "intrinsic_matrix": [500, 0, 0, 0, 505, 0, 310, 230, 1], "dist": {FOUR}}}',
    "<?xml version=\"1.0\"?><calibration><projection>frame</projection><width>640</width><height>480</height><f>505</f><b1>-5</b1>"
    "<cx>-9.5</cx><cy>-9.5</cy><k1>-0.2</k1><k2>0.08</k2><p1>-0.0005</p1><p2>0.001</p2></calibration>",
    (SIZE + MATRIX + f"dist: {FOUR}\n").encode("utf-16"), b"\xef\xbb\xbf%YAML:1.0\n" + (SIZE + MATRIX + f"dist: {FOUR}\n").encode(),
    f"a: &a {{resolution: [640, 480]}}\ncam0:\n  <<: *a\n  intrinsics: [500, 505, 310, 230]\n  distortion: {FOUR}\n  distortion_model: radtan\n",
])
def test_all_of_them_say_the_same(tmp_path, text):
    lens = lens_of_file(tmp_path, text)
    assert lens.intrinsics_px == (500, 505, 310, 230) and (lens.width_px, lens.height_px) == (640, 480)
    assert lens.native and lens.coefficients[:4] == (-0.2, 0.08, 0.001, -0.0005) and not any(lens.coefficients[4:])


def test_camodocal_s_wide_models(tmp_path):
    numbers = "projection_parameters: {gamma1: 500, gamma2: 505, u0: 310, v0: 230}\nmirror_parameters: {xi: 1.1}\n"
    assert lens_of_file(tmp_path, CAMODOCAL.format("MEI") + numbers).coefficients == (1.1, -0.2, 0.08, 0.001, -0.0005)
    numbers = "projection_parameters: {k2: 0.1, k3: 0.2, k4: 0.3, k5: 0.4, mu: 500, mv: 505, u0: 310, v0: 230}\n"
    lens = lens_of_file(tmp_path, CAMODOCAL.format("KANNALA_BRANDT") + numbers)
    assert lens.model == "equidistant" and lens.coefficients == (0.1, 0.2, 0.3, 0.4) and lens.intrinsics_px == (500, 505, 310, 230)


@pytest.mark.parametrize(("text", "says"), [
    (SIZE + MATRIX + MATRIX, "camera_matrix: field is there twice"),
    (SIZE + MATRIX + "%opencv\n" + SIZE, "image_width: field is there twice"),
    (SIZE + MATRIX + "dist: [.nan, 0, 0, 0]\n", "coefficients nan, 0, 0, 0: allowed are finite numbers"),
    (SIZE + MATRIX + "dist: [0.1, -.inf, 0, 0]\n", "allowed are finite numbers"),
    (SIZE + MATRIX + "lens_distortion: [1, 0, 0, 0]\n", "lens_distortion: looks like a distortion, but is none that is read"),
    (SIZE + MATRIX + "k1: 0.1\nk2: 0\nk3: 0\nk4: 0.1\n", "k1 to k4 without p1 and p2, and no distortion_model"),
    (SIZE + MATRIX + "dist: [-0,25, 0,08, 0,001, 0,0005]\n", "where commas stand for decimal points"),
    (SIZE + "camera_matrix: [888,9, 0, 319,5, 0, 888,9, 239,5, 0, 0, 1]\n", "needed are 9; where commas stand for decimal points"),
    ("MATLAB 5.0 MAT-file", "a MAT file"), (b"\x80\x04", "a pickle, which is not opened"), (b"\x93NUMPY", "a single NumPy array"),
    ("<x:xmpmeta xmlns:x='adobe:ns:meta/'/>", "XML of a kind that is not read (xmpmeta)"),
    ("<calibration><projection>fisheye</projection><f>1</f></calibration>", "Metashape's projection 'fisheye'"),
    ("<calibration><width>2</width><height>2</height><f>9</f><k4>0.1</k4></calibration>", "Metashape's k4 0.1"),
    ("{'lensmodel': 'LENSMODEL_CAHVOR', 'intrinsics': [1]}", "LENSMODEL_CAHVOR, allowed are LENSMODEL_PINHOLE"),
    (CAMODOCAL.format("SCARAMUZZA"), "model_type SCARAMUZZA, allowed are PINHOLE, MEI"),
    ("aprilcal { fc = [1]; }\n", "not a table of fields; read are YAML"),
])
def test_others_are_refused_for_their_own_reason(tmp_path, text, says):
    with pytest.raises(BadInput) as problem:
        lens_of_file(tmp_path, text)
    assert says in str(problem.value)


def test_a_number_with_points_brings_no_hint_on_commas(tmp_path):
    with pytest.raises(BadInput) as problem:
        lens_of_file(tmp_path, SIZE + "camera_matrix: [888.9,0,319.5, 0,888.9]\n")
    assert "commas" not in str(problem.value)


def test_a_folder_is_no_calibration(tmp_path):
    with pytest.raises(BadInput, match="a folder without cameras.bin or cameras.txt"):
        read_lens(tmp_path)


def test_numbers_of_the_command_line():
    assert lens_of_numbers("500 505 310 230").intrinsics_px == lens_of_numbers("500, 505,310,230").intrinsics_px == (500, 505, 310, 230)
    with pytest.raises(BadInput, match="8 numbers, needed are 4 with decimal points"):
        lens_of_numbers("888,9,888,9,319,5,239,5")
