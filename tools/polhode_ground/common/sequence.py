"""Reads an image sequence in the ASL layout: its camera, its list of frames, its pixels."""

import json
import pathlib
import subprocess
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import depth_of, eight_bits, read_levels
from polhode_ground.common.mosaic import without_mosaic
from polhode_ground.common.program import PROGRAM, RUNNER, check_program


@dataclass
class Camera:
    """Pinhole with radial-tangential distortion; pixel centres at integer coordinates."""

    width_px: int
    height_px: int
    intrinsics_px: np.ndarray  # fu, fv, cu, cv
    distortion: np.ndarray  # k1, k2, p1, p2
    line_time_ns: float = 0.0  # from one row to the next below it; 0: a global shutter

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
    rate_hz: float | None = None  # of the camera, where sensor.yaml names it
    intrinsics_known: bool = True
    fields: dict[str, str] = field(default_factory=dict)  # of sensor.yaml, those of one value
    depth_bits: int | None = None  # of levels in 16-bit pictures, as a replay found them or was told; None: to be found
    mosaic: bool = False  # a replay took one out of the pictures

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

    def see_as(self, summary: dict[str, Any]) -> None:
        """As the replay did that wrote this summary.json."""
        self.depth_bits, self.mosaic = summary.get("depth_bits"), bool(summary.get("mosaic"))

    def read_gray(self, index: int) -> np.ndarray:
        """Frame as uint8 [H,W], as bright as the replay sees it; colours become luminance."""
        levels, _ = read_levels(self.frame_path(index))
        if levels.dtype != np.uint8 and self.depth_bits is None:
            self.depth_bits = depth_of([self.frame_path(i) for i in range(len(self.filenames))])
        gray = eight_bits(levels, self.depth_bits or 8)
        return without_mosaic(gray) if self.mosaic else gray


def read_tables(folder: pathlib.Path, any_lens: bool) -> dict[str, Any]:
    """data.csv and sensor.yaml as the program reads them: what replays is what is judged and shown."""
    check_program()
    words: list[str | pathlib.Path] = [*RUNNER, PROGRAM, "sequence", *(["--any-lens"] if any_lens else []), "--", folder]
    done = subprocess.run(words, capture_output=True)
    if done.returncode != 0:
        said = done.stderr.decode(errors="backslashreplace").strip().splitlines()[-1:]
        raise BadInput(" ".join(said).removeprefix("polhode: ") or f"{folder}: {PROGRAM} ended with {done.returncode}")
    tables: dict[str, Any] = json.loads(done.stdout)
    return tables


def read_sequence(folder: pathlib.Path, any_lens: bool = False) -> Sequence:
    """Opens the folder SEQ; frames themselves are read on demand.

    @param any_lens  `intrinsics: auto` is taken, too; the camera's intrinsics are a guess then
    """
    folder = pathlib.Path(folder)
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such sequence folder")
    tables = read_tables(folder, any_lens)
    width_px, height_px = tables["resolution"]
    camera = Camera(
        width_px,
        height_px,
        np.array(tables["intrinsics"], dtype=float),
        np.array(tables["distortion_coefficients"], dtype=float),
        tables["line_time_ns"],
    )
    frames = tables["frames"]
    return Sequence(
        folder,
        camera,
        np.array([time_ns for time_ns, _ in frames], dtype=np.int64),
        [name for _, name in frames],
        tables["rate_hz"],
        tables["intrinsics_known"],
        tables["fields"],
    )


def read_json(path: pathlib.Path) -> dict[str, Any]:
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
