"""Writes a sequence in the ASL layout, as `polhode replay` reads it, with an account of where it is from."""

import json
import pathlib
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from importing.lens import RADTAN, Lens, Undistorter, scaled_to
from importing.pictures import open_picture, read_pixels, turned
from importing.source import NS, READ_BY_REPLAY, Account, Frame

from judge.errors import BadInput

SENSOR = """\
# {said}
sensor_type: camera
rate_hz: {rate:.6g}
resolution: [{lens.width_px}, {lens.height_px}]
camera_model: pinhole
intrinsics: {intrinsics}  # fu, fv, cu, cv [px]; the centre of the top-left pixel is (0, 0)
distortion_model: radial-tangential
distortion_coefficients: [{k1:.10g}, {k2:.10g}, {p1:.10g}, {p2:.10g}]
"""


def numbers_text(lens: Lens) -> str:
    return "[" + ", ".join(f"{value:.10g}" for value in lens.intrinsics_px) + "]"


def write_sensor(path: pathlib.Path, lens: Lens, rate_hz: float, said: str, intrinsics: str | None = None) -> None:
    """@param intrinsics  the text in place of the lens' numbers: `auto`"""
    k1, k2, p1, p2 = lens.coefficients[:4]
    path.write_text(SENSOR.format(said=" ".join(said.split()), rate=rate_hz, lens=lens, intrinsics=intrinsics or numbers_text(lens), k1=k1, k2=k2, p1=p1, p2=p2))


@dataclass
class Writer:
    """Frames go to SEQ/mav0/cam0 of a folder beside it, which takes its place when all is written."""

    folder: pathlib.Path
    lens: Lens | None  # None: not known yet
    where: str  # the lens is from
    account: Account
    rows: list[tuple[int, str]] = field(default_factory=list)
    size: tuple[int, int] | None = None
    undistort: Undistorter | None = None

    def __post_init__(self) -> None:
        self.beside = self.folder.with_name(self.folder.name + ".new")
        shutil.rmtree(self.beside, ignore_errors=True)
        try:
            (self.beside / "mav0/cam0/data").mkdir(parents=True)
        except OSError as problem:
            raise BadInput(f"{self.beside}: {problem.strerror}") from None

    def write_all(self, frames: Iterator[Frame], progress) -> None:
        for frame in frames:
            self._write(frame)
            progress(len(self.rows))

    def _write(self, frame: Frame) -> None:
        try:
            as_it_is, pixels, size = self._take(frame)
        except BadInput:
            self.account.dropped["picture can't be read"] += 1
            return
        if self.size is None:
            self._begin(size)
        if size != self.size:
            self.account.dropped[f"another size than {self.size[0]}x{self.size[1]}"] += 1
            return
        if self.undistort is not None:
            as_it_is, pixels = False, self.undistort(read_pixels(frame.file) if pixels is None else pixels)
        name = f"{frame.timestamp_ns}{frame.file.suffix.lower() if as_it_is else '.png'}"
        target = self.beside / "mav0/cam0/data" / name
        if as_it_is:
            shutil.copyfile(frame.file, target)
        else:
            from PIL import Image
            Image.fromarray(pixels).save(target, compress_level=1)
        self.rows.append((frame.timestamp_ns, name))

    def _take(self, frame: Frame) -> tuple[bool, np.ndarray | None, tuple[int, int]]:
        """(the file may be copied, else its pixels, size)."""
        if frame.pixels is not None:
            return False, frame.pixels, (frame.pixels.shape[1], frame.pixels.shape[0])
        with open_picture(frame.file) as picture:
            plain = picture.mode in ("L", "RGB") or picture.mode.startswith("I;16")
            if frame.file.suffix.lower() in READ_BY_REPLAY and plain and turned(picture) == 1:
                return True, None, picture.size
        pixels = read_pixels(frame.file)
        return False, pixels, (pixels.shape[1], pixels.shape[0])

    def _begin(self, size: tuple[int, int]) -> None:
        """With the first picture the size is known, and what is to be done about the lens."""
        self.size = size
        if self.lens is None:
            return
        self.lens, assumed = scaled_to(self.lens, *size, self.where)
        if assumed:
            self.account.assumed.append(assumed)
        if not self.lens.native:
            what = "equidistant" if self.lens.model != RADTAN else f"with {len(self.lens.coefficients)} coefficients"
            self.account.assumed.append(f"the lens is {what}: the pictures are undistorted")
            self.undistort = Undistorter(self.lens)
            self.lens = self.undistort.lens

    def rate_hz(self) -> float:
        """Of the frames in the mean; 1 of a single one."""
        span_ns = self.rows[-1][0] - self.rows[0][0]
        return (len(self.rows) - 1) * NS / span_ns if span_ns else 1.0

    def finish(self, record: dict) -> None:
        camera = self.beside / "mav0/cam0"
        (camera / "data.csv").write_text("#timestamp [ns],filename\n" + "".join(f"{time},{name}\n" for time, name in self.rows))
        lens = self.lens or centred(*self.size)
        write_sensor(camera / "sensor.yaml", lens, self.rate_hz(), f"intrinsics: {self.where}", None if self.lens else "auto")
        (self.beside / "import.json").write_text(json.dumps(record | {"frames": len(self.rows), "intrinsics_from": self.where}, indent=2) + "\n")
        if self.folder.exists():
            shutil.rmtree(self.folder)
        self.beside.rename(self.folder)

    def abandon(self) -> None:
        shutil.rmtree(self.beside, ignore_errors=True)


def centred(width_px: int, height_px: int) -> Lens:
    """A lens of unknown focal length: the longer edge is a guess that every estimate begins with."""
    focal_px = float(max(width_px, height_px))
    return Lens(width_px, height_px, (focal_px, focal_px, (width_px - 1) / 2, (height_px - 1) / 2))
