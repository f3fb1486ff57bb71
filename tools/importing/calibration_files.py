"""Lenses out of the files that calibrations leave: Kalibr, OpenCV, ROS, EuRoC and Polhode's own sensor.yaml."""

import pathlib

from importing.lens import Lens, lens_of
from judge.errors import BadInput

MATRIX_KEYS = ("camera_matrix", "cameraMatrix", "CameraMatrix", "camera_Matrix", "K", "M1")
DISTORTION_KEYS = ("distortion_coefficients", "dist_coeffs", "distCoeffs", "dist_coeff", "Distortion_Coefficients", "D", "D1")


def read_lens(path: pathlib.Path, camera: str = "cam0") -> Lens:
    """@param camera  which of a Kalibr camchain's cameras."""
    if not path.is_file():
        raise BadInput(f"{path}: no such calibration file")
    values = _opencv_values(path) or _yaml_values(path)
    if camera in values and isinstance(values[camera], dict):
        values = values[camera]
    elif any(key.startswith("cam") and isinstance(value, dict) and "intrinsics" in value for key, value in values.items()):
        raise BadInput(f"{path}: camera '{camera}' is not in it, it has {', '.join(values)}")
    if "intrinsics" in values:
        return _kalibr_or_euroc(path, values)
    if any(key in values for key in MATRIX_KEYS):
        return _opencv_or_ros(path, values)
    raise BadInput(f"{path}: holds neither intrinsics (Kalibr, EuRoC) nor a camera matrix (OpenCV, ROS); it has {', '.join(map(str, values)) or 'nothing'}")


def _opencv_values(path: pathlib.Path) -> dict:
    """What cv::FileStorage wrote, if it did: XML, JSON, or YAML with matrices of its own type."""
    import cv2
    text = path.read_text(errors="replace")
    if "opencv" not in text:
        return {}
    try:
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        node = storage.root()
        return {key: _node_value(node.getNode(key)) for key in node.keys()}
    except (cv2.error, SystemError) as problem:
        raise BadInput(f"{path}: OpenCV can't read it: {str(problem).strip().splitlines()[-1]}") from None


def _node_value(node):
    if node.isInt() or node.isReal():
        return node.real()
    if node.isString():
        return node.string()
    matrix = node.mat() if node.isMap() else None
    if matrix is not None:
        return matrix.ravel().tolist()
    return [_node_value(node.at(i)) for i in range(node.size())] if node.isSeq() else None


def _yaml_values(path: pathlib.Path) -> dict:
    import yaml
    lines = path.read_text(errors="replace").splitlines()
    # EuRoC in the wild begins with OpenCV's "%YAML:1.0", which is no YAML.
    text = "\n".join(line for line in lines if not line.startswith("%"))
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as problem:
        raise BadInput(f"{path}: not YAML: {' '.join(str(problem).split())}") from None
    if not isinstance(values, dict):
        raise BadInput(f"{path}: not a table of fields")
    return values


def _flat(value) -> list:
    """Numbers of a list, of rows of lists, or of ROS' {rows, cols, data}."""
    if isinstance(value, dict):
        value = value.get("data", [])
    if not isinstance(value, (list, tuple)):
        return [] if value is None else [value]
    return [item for row in value for item in (row if isinstance(row, list) else [row])]


def _kalibr_or_euroc(path: pathlib.Path, values: dict) -> Lens:
    model = values.get("camera_model", "pinhole")
    if model != "pinhole":
        raise BadInput(f"{path}: camera_model '{model}', allowed is pinhole")
    if values["intrinsics"] == "auto":
        raise BadInput(f"{path}: intrinsics: auto, not numbers yet")
    width_px, height_px = (_flat(values.get("resolution")) or [0, 0])[:2]
    coefficients = values.get("distortion_coefficients", values.get("distortion_coeffs", []))
    return lens_of(width_px, height_px, _flat(values["intrinsics"]), str(values.get("distortion_model", "")), _flat(coefficients), str(path))


def _opencv_or_ros(path: pathlib.Path, values: dict) -> Lens:
    matrix = _flat(next(values[key] for key in MATRIX_KEYS if key in values))
    if len(matrix) != 9:
        raise BadInput(f"{path}: the camera matrix has {len(matrix)} numbers, needed are 9")
    coefficients = _flat(next((values[key] for key in DISTORTION_KEYS if key in values), []))
    size = _flat(values.get("image_size")) or [values.get("image_width", values.get("image_Width", 0)), values.get("image_height", values.get("image_Height", 0))]
    model = values.get("distortion_model") or ("fisheye" if values.get("fisheye_model") else "")
    return lens_of(size[0], size[1], (matrix[0], matrix[4], matrix[2], matrix[5]), str(model), coefficients, str(path))
