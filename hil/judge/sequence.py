"""Reads an image sequence in the ASL layout: its camera, its list of frames, its pixels."""

import ast
import json
import pathlib
from dataclasses import dataclass

import numpy as np

from judge.errors import BadInput
from judge.tables import read_cells, timestamps


@dataclass
class Camera:
    """Pinhole with radial-tangential distortion; pixel centres at integer coordinates."""

    width_px: int
    height_px: int
    intrinsics_px: np.ndarray  # fu, fv, cu, cv
    distortion: np.ndarray  # k1, k2, p1, p2

    def project(self, p_C: np.ndarray) -> np.ndarray:
        """Distorted pixel coordinates [N,2] of points p_C [N,3] in the camera frame; NaN behind the camera."""
        fu, fv, cu, cv = self.intrinsics_px
        k1, k2, p1, p2 = self.distortion
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = np.where(p_C[:, 2:] > 0, p_C[:, :2] / p_C[:, 2:], np.nan).T
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2 * r2
        x_distorted = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        y_distorted = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.stack([fu * x_distorted + cu, fv * y_distorted + cv], axis=1)


@dataclass
class Sequence:
    """A folder SEQ: frames [N] with int64 time stamps, and optional truth files."""

    folder: pathlib.Path
    camera: Camera
    timestamp_ns: np.ndarray
    filenames: list[str]

    @property
    def name(self) -> str:
        return self.folder.resolve().name

    @property
    def truth_path(self) -> pathlib.Path:
        return self.folder / "truth.csv"

    @property
    def model_path(self) -> pathlib.Path:
        return self.folder / "model.ply"

    def frame_path(self, index: int) -> pathlib.Path:
        return self.folder / "mav0" / "cam0" / "data" / self.filenames[index]

    def read_gray(self, index: int) -> np.ndarray:
        """Frame as uint8 [H,W]; 16-bit pictures are scaled by their depth, colours to luminance."""
        from PIL import Image
        try:
            with Image.open(self.frame_path(index)) as picture:
                if picture.mode.startswith("I"):
                    return (np.asarray(picture).astype(np.uint32) >> 8).astype(np.uint8)
                return np.asarray(picture.convert("L"))
        except OSError as problem:
            raise BadInput(f"{self.frame_path(index)}: {problem}") from None


def yaml_values(path: pathlib.Path) -> dict[str, str]:
    """Top-level `key: value` lines; sensor.yaml needs no more of YAML than this."""
    try:
        lines = path.read_text().splitlines()
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None
    values = {}
    for line in lines:
        line = line.split("#", 1)[0].rstrip()
        if ":" in line and not line.startswith((" ", "\t", "-")):
            key, value = line.split(":", 1)
            values[key.strip()] = value.strip()
    return values


def _floats(path: pathlib.Path, values: dict[str, str], key: str, count: int) -> np.ndarray:
    if key not in values:
        raise BadInput(f"{path}: {key} is missing")
    try:
        numbers = np.array(ast.literal_eval(values[key]), dtype=float)
    except (ValueError, SyntaxError, TypeError):
        raise BadInput(f"{path}: {key} is '{values[key]}', not a list of numbers") from None
    if numbers.shape != (count,):
        raise BadInput(f"{path}: {key} needs {count} numbers, has {numbers.size}")
    return numbers


def read_camera(path: pathlib.Path) -> Camera:
    """Camera of a sensor.yaml: pinhole, radial-tangential."""
    values = yaml_values(path)
    for key, allowed in (("camera_model", "pinhole"), ("distortion_model", "radial-tangential")):
        if values.get(key, allowed).strip("\"'") != allowed:
            raise BadInput(f"{path}: {key} is '{values[key]}', only '{allowed}' is known")
    width_px, height_px = _floats(path, values, "resolution", 2).astype(int)
    return Camera(int(width_px), int(height_px), _floats(path, values, "intrinsics", 4),
                  _floats(path, values, "distortion_coefficients", 4))


def read_sequence(folder: pathlib.Path) -> Sequence:
    """Opens the folder SEQ; frames themselves are read on demand."""
    folder = pathlib.Path(folder)
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such sequence folder")
    cam0 = folder / "mav0" / "cam0"
    _, rows = read_cells(cam0 / "data.csv")
    if not rows or len(rows[0]) < 2:
        raise BadInput(f"{cam0 / 'data.csv'}: no rows 'timestamp,filename'")
    return Sequence(folder, read_camera(cam0 / "sensor.yaml"),
                    timestamps(cam0 / "data.csv", [row[0] for row in rows]), [row[1] for row in rows])


def read_json(path: pathlib.Path) -> dict:
    """A JSON object from a file; {} where the file does not exist."""
    try:
        value = json.loads(pathlib.Path(path).read_text())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as problem:
        raise BadInput(f"{path}: {problem}") from None
    if not isinstance(value, dict):
        raise BadInput(f"{path}: a JSON object is needed")
    return value
