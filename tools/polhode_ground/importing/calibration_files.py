"""Lenses out of the files that calibrations leave: Kalibr, OpenCV, NumPy, ROS, EuRoC, COLMAP and Polhode's own sensor.yaml."""

import pathlib
import zipfile
from dataclasses import replace

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.calibration_text import opencv_values, text_of, with_hint, yaml_values
from polhode_ground.importing.calibration_tools import (
    camodocal,
    coefficients_of,
    flat,
    intrinsics_of,
    matlab,
    mrcal,
    plain,
    size_of,
    xml_lens,
)
from polhode_ground.importing.camera_info import lens_of_info
from polhode_ground.importing.colmap_lens import read_cameras
from polhode_ground.importing.lens import Lens, lens_of
from polhode_ground.importing.row_times import row_time_of

NO_DISTORTION = "{} tells no coefficients of a distortion: none is assumed"
MATRIX_KEYS = (
    "camera_matrix",
    "cameraMatrix",
    "CameraMatrix",
    "camera_Matrix",
    "Camera_Matrix",
    "K",
    "mtx",
    "intrinsic_matrix",
    "intrinsics_matrix",
    "M1",
    "K1",
    "cameraMatrix1",
    "camera_matrix_1",
)
FIRST_OF_TWO = ("M1", "K1", "cameraMatrix1", "camera_matrix_1")
SIZE_KEYS = ("image_size", "imageSize", "img_size", "resolution")
SHAPE_KEYS = ("img_shape", "image_shape", "shape")
MODEL_KEYS = ("distortion_model", "Camera.type", "camera_model", "model")
OTHERS = {"model_type": camodocal, "lensmodel": mrcal, "FocalLength": matlab}
COLMAP_FILES = ("cameras.bin", "cameras.txt")
SKEW_MAX = 1e-3  # of the focal length: less moves no point of a picture by a pixel
# Kalibr's cameras beside pinholes: how many numbers stand before fu, fv, cu, cv.
KALIBR_CAMERAS = {"omni": 1, "ds": 2, "eucm": 2}


def read_lens(path: pathlib.Path, camera: str = "cam0") -> Lens:
    """@param camera  which of a Kalibr camchain's cameras, or the number of one of COLMAP's."""
    path = next(
        (folder / name for folder in (path, path / "0", path / "sparse/0") for name in COLMAP_FILES if (folder / name).is_file()), path
    )
    if path.is_dir():
        raise BadInput(f"{path}: a folder without {' or '.join(COLMAP_FILES)}; name a calibration file")
    if not path.is_file():
        raise BadInput(f"{path}: no such calibration file")
    if path.name in COLMAP_FILES:
        return read_cameras(path, camera)
    if path.suffix != ".npz" and not (values := opencv_values(path)) and (lens := xml_lens(path, text_of(path))):
        return lens
    values = _numpy_values(path) if path.suffix == ".npz" else values or yaml_values(path)
    notes = ()
    chain = [key for key, value in values.items() if str(key).startswith("cam") and isinstance(value, dict) and "intrinsics" in value]
    several = len(chain) > 1 and camera in chain
    others = tuple((key, tuple(flat(values[key].get("resolution")))) for key in chain if key != camera) if several else ()
    if camera in values and isinstance(values[camera], dict):
        notes = (f"{path}: camera {camera} of {', '.join(chain)}: --camera takes another",) if len(chain) > 1 else ()
        values = values[camera]
    elif chain:
        raise BadInput(f"{path}: camera '{camera}' is not in it, it has {', '.join(values)}: choose one by --camera")
    if len(values) == 1 and isinstance(next(iter(values.values())), dict):  # as a node of ROS keeps its parameters
        values = next(iter(values.values()))
    try:
        lens = _lens_of_values(path, values)
    except BadInput as problem:
        raise BadInput(
            f"{problem}{'' if path.suffix == '.npz' or 'decimal points' in str(problem) else with_hint(text_of(path))}"
        ) from None
    line_time_ns, said = row_time_of(values, str(path))
    lens, notes = (
        replace(lens, line_time_ns=line_time_ns, camera=camera if several else "", others=others),
        notes + ((said,) if said else ()),
    )
    if not lens.width_px:
        notes += (f"{path} tells no size of pictures: it is taken to be of these",)
    return replace(lens, notes=lens.notes + notes)


def _lens_of_values(path: pathlib.Path, values: dict) -> Lens:
    for key, reader in OTHERS.items():
        if key in values:
            return reader(path, values)
    if "intrinsics" in values and not isinstance(values["intrinsics"], dict):
        return _kalibr_or_euroc(path, values)
    if any(key in values for key in ("K", "k")) and "distortion_model" in values and "width" in values:
        return lens_of_info(values, False, str(path))  # a message, as `ros2 topic echo` prints it
    if any(
        key in values and not isinstance(values[key], dict) or isinstance(values.get(key), dict) and "data" in values[key]
        for key in MATRIX_KEYS
    ):
        return _opencv_or_ros(path, values)
    if intrinsics_of(values):
        return _of_numbers(path, values, intrinsics_of(values))
    raise BadInput(
        f"{path}: holds neither intrinsics (Kalibr, EuRoC) nor a camera matrix (OpenCV, ROS); it has {', '.join(map(str, values)) or 'nothing'}"
    )


def _numpy_values(path: pathlib.Path) -> dict:
    """What numpy.savez wrote of OpenCV's results."""
    import numpy as np

    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {key: arrays[key].tolist() for key in arrays.files}
    except (OSError, ValueError, zipfile.BadZipFile) as problem:
        raise BadInput(f"{path}: NumPy can't read it: {problem}") from None


def _kalibr_or_euroc(path: pathlib.Path, values: dict) -> Lens:
    model, distortion = values.get("camera_model", "pinhole"), str(values.get("distortion_model", ""))
    if values["intrinsics"] == "auto":
        raise BadInput(f"{path}: intrinsics: auto, not numbers yet")
    size = _size_of(values)
    numbers = flat(values["intrinsics"])
    coefficients = coefficients_of(values, distortion, str(path)) or []
    if model == "pinhole":
        lens = lens_of(*size, numbers, distortion, coefficients, str(path))
        return lens if coefficients or distortion == "none" else replace(lens, notes=(NO_DISTORTION.format(path),))
    if model not in KALIBR_CAMERAS:
        raise BadInput(f"{path}: camera_model '{model}', allowed are pinhole, {', '.join(KALIBR_CAMERAS)}")
    own = numbers[: KALIBR_CAMERAS[model]]
    if model == "omni" and distortion in ("radtan", "none", ""):
        own += coefficients or [0.0] * 4
    elif any(coefficients):
        raise BadInput(
            f"{path}: camera_model '{model}' with distortion_model '{distortion}', allowed is {'radtan or ' * (model == 'omni')}none"
        )
    return lens_of(*size, numbers[KALIBR_CAMERAS[model] :], model, own, str(path))


def _opencv_or_ros(path: pathlib.Path, values: dict) -> Lens:
    key = next(key for key in MATRIX_KEYS if key in values)
    matrix = flat(values[key])
    if key == "intrinsic_matrix" and len(matrix) == 9 and size_of(values)[0]:  # Open3D's stands by columns
        matrix = [value for column in range(3) for value in matrix[column::3]] if any(matrix[6:8]) else matrix
    lens = _of_numbers(path, values, _of_matrix(path, key, matrix))
    return replace(lens, notes=(f"{path}: {key} is taken, the first camera of two", *lens.notes)) if key in FIRST_OF_TWO else lens


def _size_of(values: dict) -> list:
    """Width and height; an array's shape of three numbers is of rows, columns and colours."""
    given = next((values[name] for name in SIZE_KEYS if values.get(name)), None)
    if given is not None:
        return (size_of(given) if isinstance(given, dict) and "data" not in given else flat(given))[:2]
    shape = next((flat(values[name]) for name in SHAPE_KEYS if len(flat(values.get(name))) == 3), None)
    return [shape[1], shape[0]] if shape else size_of(values)


def _of_numbers(path: pathlib.Path, values: dict, intrinsics) -> Lens:
    """Of a table with fu, fv, cu, cv, and what else such tables hold."""
    model = next((str(values[name]) for name in MODEL_KEYS if values.get(name)), "fisheye" if values.get("fisheye_model") else "")
    coefficients = coefficients_of(values, model, str(path)) or []
    if plain(model).endswith("brownconrady") and not any(coefficients):
        model = ""  # of RealSense: each of its kinds is none where all is 0
    if "xi" in values:
        model, coefficients = "omni", [*flat(values["xi"]), *(coefficients or [0.0] * 4)]
    lens = lens_of(*_size_of(values), intrinsics, model, coefficients, str(path))
    notes = []
    if not coefficients:
        notes.append(NO_DISTORTION.format(path))
    if not model and len(coefficients) == 4 and any(map(float, coefficients)):
        notes.append(f"{path} names no distortion model: its coefficients are taken to be radial-tangential, not those of a fisheye lens")
    return replace(lens, notes=tuple(notes))


def _of_matrix(path: pathlib.Path, key: str, matrix: list) -> tuple:
    """fu, fv, cu, cv of a camera matrix."""
    try:
        matrix = [float(value) for value in matrix]
    except (TypeError, ValueError):
        raise BadInput(f"{path}: {key} is {matrix}, needed are 9 numbers") from None
    if len(matrix) != 9:
        raise BadInput(f"{path}: {key} has {len(matrix)} numbers, needed are 9")
    if any(matrix[6:8]) and not any((matrix[2], matrix[5])):
        raise BadInput(f"{path}: {key}: the principal point stands in the last row, as in MATLAB; needed is the transposed matrix")
    if abs(matrix[1]) > SKEW_MAX * abs(matrix[0]):
        raise BadInput(
            f"{path}: {key}: a skew of {matrix[1]:g} px, allowed is up to {SKEW_MAX * matrix[0]:.2g}: axes of pixels at a right angle"
        )
    return matrix[0], matrix[4], matrix[2], matrix[5]
