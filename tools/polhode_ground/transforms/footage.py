"""A sequence in hand: its frames in the order of delivery, each with the truth of its time stamp; read, changed, written.

Transforms change the list of shots and what they hold. Most pixels are made only while the result is written; those of
frames spoiled by chance are held until then.
"""

import csv
import json
import pathlib
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.fault_log import LOG_FILE, LogEntry, write_log
from polhode_ground.common.sequence import Camera, read_json, read_sequence
from polhode_ground.common.tables import POSITION, QUATERNION, RATE, VELOCITY, read_motion

TRUTH_COLUMNS = ("timestamp_ns", *POSITION, *QUATERNION, *VELOCITY, *RATE)
ATTITUDE_FILE = "servicer_attitude.csv"


@dataclass(frozen=True)
class Shot:
    """One delivered frame. Truth holds at its time stamp, whatever the picture shows; NaN is unknown."""

    timestamp_ns: int
    pixels: Callable[[], np.ndarray]  # uint8 [H,W]
    file: pathlib.Path | None  # the picture as it is on disk, where nothing has changed it
    q_CT: np.ndarray  # w, x, y, z
    p_CT: np.ndarray  # m
    v_C: np.ndarray  # m/s
    w_T: np.ndarray  # rad/s
    q_IC: np.ndarray | None = None  # what the servicer knows of its own attitude

    def redrawn(self, change: Callable[[np.ndarray], np.ndarray]) -> "Shot":
        """The shot with changed pixels."""
        before = self.pixels
        return replace(self, pixels=lambda: change(before()), file=None)

    def showing(self, other: "Shot") -> "Shot":
        """The shot with another one's picture."""
        return replace(self, pixels=other.pixels, file=other.file)


@dataclass
class Footage:
    """A sequence as a list of shots; transforms return another one."""

    camera: Camera
    rate_hz: float
    shots: list[Shot]
    model: pathlib.Path | None  # mesh in T [m]
    scene: dict  # scene.json
    log: list[LogEntry] = field(default_factory=list)
    mirror: bool = False  # the mesh is to be mirrored in T's x

    @property
    def period_s(self) -> float:
        """Usual time between frames."""
        stamps = [shot.timestamp_ns for shot in self.shots]
        return float(np.median(np.diff(stamps))) * 1e-9 if len(stamps) > 1 else 1.0 / self.rate_hz

    def ramps(self, options: dict) -> np.ndarray:
        """[N] 1 in the frames from `from_part` to `to_part` of the footage, 0 outside, with ramps of `ramp_part` beside them."""
        part, ramp = np.arange(len(self.shots)) / max(len(self.shots) - 1, 1), options["ramp_part"]
        return np.clip(np.minimum((part - options["from_part"] + ramp) / ramp, (options["to_part"] + ramp - part) / ramp), 0, 1)

    def changed(self, shots: list[Shot], log=(), **fields) -> "Footage":
        return replace(self, shots=shots, log=[*self.log, *log], **fields)


def noisy(gray: np.ndarray, sigma_gray: float, rng) -> np.ndarray:
    """Normal noise of every pixel, independent."""
    return np.clip(np.rint(gray + rng.normal(0.0, sigma_gray, gray.shape)), 0, 255).astype(np.uint8)


def _attitudes(path: pathlib.Path) -> dict[int, np.ndarray]:
    """q_IC by time stamp; {} where the sequence has no such file."""
    if not path.exists():
        return {}
    rows = [
        line.replace(",", " ").split() for line in path.read_text(encoding="utf-8-sig").splitlines() if line and not line.startswith("#")
    ]
    try:
        return {int(row[0]): np.array(row[1:5], dtype=float).reshape(4) for row in rows}
    except (ValueError, IndexError):
        raise BadInput(f"{path}: allowed are rows timestamp_ns,q_IC_w,q_IC_x,q_IC_y,q_IC_z") from None


def read_footage(folder: pathlib.Path) -> Footage:
    """Opens the sequence SEQ; frames without a row in truth.csv have unknown truth."""
    sequence = read_sequence(folder)
    truth = read_motion(sequence.truth_path) if sequence.truth_path.exists() else None
    row_at = {int(stamp): i for i, stamp in enumerate(truth.timestamp_ns)} if truth else {}
    attitude = _attitudes(sequence.folder / ATTITUDE_FILE)
    unknown = [np.full(size, np.nan) for size in (4, 3, 3, 3)]
    shots = []
    for index, stamp in enumerate(int(value) for value in sequence.timestamp_ns):
        row = row_at.get(stamp)
        known = unknown if row is None else [values[row] for values in (truth.q_CT, truth.p_CT, truth.v_C, truth.w_T)]
        shots.append(Shot(stamp, lambda i=index: sequence.read_gray(i), sequence.frame_path(index), *known, attitude.get(stamp)))
    return Footage(
        sequence.camera,
        sequence.rate_hz or 1.0,
        shots,
        sequence.model_path if sequence.model_path.exists() else None,
        read_json(folder / "scene.json"),
    )


def _write_picture(shot: Shot, data: pathlib.Path) -> str:
    """A picture that nothing changed has the same octets; a changed one is a PNG."""
    import cv2

    if shot.file is not None:
        name = f"{shot.timestamp_ns}{shot.file.suffix}"
        shutil.copy(shot.file, data / name)  # no link: the source may be changed in its place
        return name
    name = f"{shot.timestamp_ns}.png"
    done, octets = cv2.imencode(".png", shot.pixels(), [cv2.IMWRITE_PNG_COMPRESSION, 3])
    if not done:
        raise BadInput(f"{data / name}: the picture can't be encoded")
    (data / name).write_bytes(octets.tobytes())
    return name


def write_sensor_yaml(path: pathlib.Path, camera: Camera, rate_hz: float) -> None:
    intrinsics, distortion = (", ".join(repr(float(x)) for x in values) for values in (camera.intrinsics_px, camera.distortion))
    path.write_text(
        f"sensor_type: camera\nrate_hz: {rate_hz!r}\nresolution: [{camera.width_px}, {camera.height_px}]\ncamera_model: pinhole\n"
        f"intrinsics: [{intrinsics}]  # fu, fv, cu, cv [px]; pixel centres at integers\n"
        f"distortion_model: radial-tangential\ndistortion_coefficients: [{distortion}]  # k1, k2, p1, p2\n"
        + (f"line_time_ns: {camera.line_time_ns!r}\n" if camera.line_time_ns else "")
    )


def _write_table(path: pathlib.Path, header, rows) -> None:
    with open(path, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(header)
        table.writerows(rows)


def _write_truth(path: pathlib.Path, shots: list[Shot]) -> None:
    rows = []
    for shot in shots:
        if np.isfinite(shot.q_CT).all():
            values = np.concatenate([shot.p_CT, shot.q_CT, shot.v_C, shot.w_T])
            rows.append([shot.timestamp_ns, *(repr(float(x)) if np.isfinite(x) else "" for x in values)])
    if rows:
        _write_table(path, TRUTH_COLUMNS, rows)


def _mirror_mesh(source: pathlib.Path, out: pathlib.Path) -> None:
    import trimesh

    mesh = trimesh.load(source, process=False)
    mesh.apply_transform(np.diag([-1.0, 1.0, 1.0, 1.0]))
    mesh.export(out)


def write_footage(footage: Footage, out: pathlib.Path) -> None:
    """Writes the folder OUT, which is not there yet; data.csv comes last and says that all is there."""
    cam0 = out / "mav0/cam0"
    (cam0 / "data").mkdir(parents=True)
    write_sensor_yaml(cam0 / "sensor.yaml", footage.camera, footage.rate_hz)
    _write_truth(out / "truth.csv", footage.shots)
    attitudes = [(shot.timestamp_ns, *(repr(float(x)) for x in shot.q_IC)) for shot in footage.shots if shot.q_IC is not None]
    if attitudes:
        _write_table(out / ATTITUDE_FILE, ("#timestamp_ns", *(f"q_IC_{axis}" for axis in "wxyz")), attitudes)
    if footage.model is not None and footage.mirror:
        _mirror_mesh(footage.model, out / "model.ply")
    elif footage.model is not None:
        shutil.copy(footage.model, out / "model.ply")
    if footage.scene:
        (out / "scene.json").write_text(json.dumps(footage.scene, indent=1) + "\n")
    write_log(out / LOG_FILE, footage.log)
    names = [_write_picture(shot, cam0 / "data") for shot in footage.shots]
    rows = [f"{shot.timestamp_ns},{name}" for shot, name in zip(footage.shots, names)]
    (cam0 / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows]) + "\n")
