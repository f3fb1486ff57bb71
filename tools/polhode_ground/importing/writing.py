"""Writes a sequence in the ASL layout, as `polhode replay` reads it, with an account of where it is from."""

import json
import pathlib
import shutil
import statistics
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import FULL_BITS, luminance
from polhode_ground.common.mosaic import contrast_of, without_mosaic
from polhode_ground.common.program import PROGRAM
from polhode_ground.common.sequence import read_tables
from polhode_ground.common.whole_file import fresh_beside
from polhode_ground.importing.decoding import Decoded, read_picture
from polhode_ground.importing.formats import READ_BY_REPLAY, kind_of_file
from polhode_ground.importing.lens import Lens, has_shape, scaled_to, shape_of_pixels
from polhode_ground.importing.pictures import open_picture, pixel_aspect, turned
from polhode_ground.importing.repeats import Repeats
from polhode_ground.importing.source import NS, Account, Frame
from polhode_ground.importing.undistorting import Undistorter

SINGLE_SHAPE = (1 / 2.4, 2.4)  # width by height; cinema has 2.39, two pictures of 4:3 side by side 2.67
UNREADABLE = "picture can't be read"
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
TURNED = "pictures are turned as EXIF says, and the intrinsics taken to be of turned pictures"


def _two_in_one(width: int, height: int) -> str:
    """Stereo cameras write both pictures into one, side by side or one above the other."""
    if SINGLE_SHAPE[0] <= width / height <= SINGLE_SHAPE[1]:
        return ""
    return f"pictures of {width}x{height}: if they show two cameras in one, cut one of them out first; they are taken for one camera's"


def numbers_text(lens: Lens) -> str:
    return "[" + ", ".join(f"{value:.10g}" for value in lens.intrinsics_px) + "]"


def write_sensor(
    path: pathlib.Path,
    lens: Lens,
    rate_hz: float,
    said: str,
    intrinsics: str | None = None,
    pixel_aspect: float = 1.0,
    line_time_ns: float = 0.0,
) -> None:
    """@param intrinsics  the text in place of the lens' numbers: `auto`"""
    k1, k2, p1, p2 = lens.coefficients[:4]
    text = SENSOR.format(
        said=" ".join(said.split()), rate=rate_hz, lens=lens, intrinsics=intrinsics or numbers_text(lens), k1=k1, k2=k2, p1=p1, p2=p2
    )
    text += f"pixel_aspect: {pixel_aspect:.15g}  # width by height of a pixel, as the source tells it\n" if pixel_aspect != 1 else ""
    text += f"line_time_ns: {line_time_ns:.10g}  # from one row to the next\n" if line_time_ns else ""
    path.write_text(text, errors="backslashreplace")  # YAML is UTF-8, names of files need not be


def write_png(path: pathlib.Path, pixels: np.ndarray, bits: int) -> None:
    """@param bits  that 16-bit levels use, for the replay; 0: it looks itself"""
    from PIL import Image, PngImagePlugin

    said = PngImagePlugin.PngInfo()
    if pixels.dtype == np.uint16 and 0 < bits <= FULL_BITS:
        said.add(b"sBIT", bytes([bits]))
    Image.fromarray(pixels).save(path, compress_level=1, pnginfo=said)


@dataclass
class Writer:
    """Frames go to SEQ/mav0/cam0 of a folder beside it, which takes its place when all is written."""

    folder: pathlib.Path
    lens: Lens | None  # None: not known yet
    where: str  # the lens is from
    account: Account
    rows: list[tuple[int, str]] = field(default_factory=list)
    size: tuple[int, int] | None = None
    aspect: float = 1.0  # width by height of a pixel
    line_time_ns: float = 0.0  # from one row to the next
    undistort: Undistorter | None = None
    mosaic: bool = False
    depth: np.dtype | None = None  # of the first picture
    mixed: bool = False
    problems: list[str] = field(default_factory=list)  # of the first file that can't be read
    repeats: Repeats = field(default_factory=Repeats)
    beside_files: tuple[pathlib.Path, ...] = ()  # to be copied

    def __post_init__(self) -> None:
        self.beside = fresh_beside(self.folder)
        try:
            (self.beside / "mav0/cam0/data").mkdir(parents=True)
        except OSError as problem:
            raise BadInput(f"{self.beside}: {problem.strerror}") from None

    def write_all(self, frames: Iterator[Frame], progress) -> None:
        for frame in frames:
            self._write(frame)
            progress(len(self.rows))
        self.repeats.tell(self.account)

    def _write(self, frame: Frame) -> None:
        try:
            as_it_is, picture, aspect = self._take(frame)
        except BadInput as problem:
            if not self.problems:
                self.problems.append(f"the first {UNREADABLE}: {problem}")
                self.account.note(self.problems[0])
            self.account.dropped[UNREADABLE] += 1
            return
        pixels = picture.pixels
        size = (pixels.shape[1], pixels.shape[0])
        if self.size is None:
            self._begin(size, aspect)
            self._write_tables([(frame.timestamp_ns, "first")])  # before hours of work
            self._asked()
        if size != self.size:
            self.account.dropped[f"another size than {self.size[0]}x{self.size[1]}"] += 1
            return
        if aspect != self.aspect:
            self.account.dropped[f"pixels of another shape than {self.aspect:.4g}:1"] += 1
            return
        self.repeats.add(pixels if pixels.ndim == 2 else luminance(pixels))
        if self.undistort is not None:
            as_it_is, pixels = False, self._undistorted(pixels)
        name = f"{frame.timestamp_ns}{READ_BY_REPLAY[kind_of_file(frame.file)] if as_it_is else '.png'}"
        self._tell_mixed(pixels, frame.file.name if frame.file else str(frame.timestamp_ns))
        target = self.beside / "mav0/cam0/data" / name
        if as_it_is:
            shutil.copyfile(frame.file, target)
        else:
            write_png(target, pixels, picture.bits)
        self.rows.append((frame.timestamp_ns, name))

    def _tell_mixed(self, pixels: np.ndarray, name: str) -> None:
        """Of whole depths alone: a camera that changed its pixel format, or pictures of two programs."""
        self.depth = self.depth or pixels.dtype
        if pixels.dtype != self.depth and not self.mixed:
            self.mixed = True
            self.account.assumed.append(
                f"pictures of 8 and of 16 bits are mixed: {name} is the first that differs; each kind is taken to fill its own scale"
            )

    def _undistorted(self, pixels: np.ndarray) -> np.ndarray:
        if not self.mosaic and (contrast := contrast_of(pixels)):
            self.mosaic = True
            self.account.assumed.append(
                f"neighbouring pixels differ by {100 * contrast:.0f} % as a colour sensor's mosaic does: levelled before the lens is undone"
            )
        # What overshoots at edges must not look like a level that the camera has.
        return np.minimum(self.undistort(without_mosaic(pixels) if self.mosaic else pixels), pixels.max())

    def _take(self, frame: Frame) -> tuple[bool, Decoded, float]:
        """(the file may be copied, what it shows, the width of a pixel by its height). Files are decoded even to be copied: a torn one is left out."""
        if frame.problem:
            raise BadInput(frame.problem)
        as_it_is = frame.pixels is None
        picture = read_picture(frame.file) if as_it_is else Decoded(frame.pixels, frame.bits)
        return as_it_is, picture, frame.pixel_aspect if frame.file is None else self._aspect_of_file(frame.file)

    def _aspect_of_file(self, path: pathlib.Path) -> float:
        """1 of formats that Pillow does not know: they tell none."""
        try:
            with open_picture(path) as picture:
                self.account.note(TURNED if turned(picture) != 1 else "")
                return pixel_aspect(picture)
        except BadInput:
            return 1.0

    def _begin(self, size: tuple[int, int], aspect: float) -> None:
        """With the first picture the size is known, and what is to be done about the lens."""
        self.size, self.aspect = size, aspect
        said = []
        if self.lens is not None:
            self.lens, scaled = scaled_to(self.lens, *size, self.where, aspect)
            self.line_time_ns = self.lens.line_time_ns or self.line_time_ns
            said = [*self.lens.notes, scaled]
        said += [shape_of_pixels(self.lens, aspect), _two_in_one(*size)]
        if self.lens is not None and not self.lens.native:
            self.undistort = Undistorter(self.lens, self.where)
            said.append(self._follow_rows())
            self.lens = self.undistort.lens
            said.append(self.undistort.words)
        for sentence in said:
            self.account.note(sentence)

    def _follow_rows(self) -> str:
        """A row of undistorted pictures is of several rows of the camera's."""
        if not self.line_time_ns:
            return ""
        self.line_time_ns *= self.lens.intrinsics_px[1] / self.undistort.lens.intrinsics_px[1]
        return (
            f"undistorted rows are not those that the camera read: line_time_ns {self.line_time_ns:.6g} holds in the middle of the picture"
        )

    def rate_hz(self) -> float:
        """Of the frames in the median, which gaps do not change; 1 of a single one."""
        times_ns = [time for time, _ in self.rows]
        return NS / statistics.median([b - a for a, b in zip(times_ns, times_ns[1:])] or [NS])

    def _write_tables(self, rows: list[tuple[int, str]]) -> None:
        camera = self.beside / "mav0/cam0"
        (camera / "data.csv").write_text("#timestamp [ns],filename\n" + "".join(f"{time},{name}\n" for time, name in rows))
        lens = self.lens or centred(*self.size)
        write_sensor(
            camera / "sensor.yaml",
            lens,
            self.rate_hz(),
            f"intrinsics: {self.where}",
            None if self.lens else "auto",
            self.aspect if has_shape(lens if self.lens else None, self.aspect) else 1.0,
            self.line_time_ns,
        )

    def _asked(self) -> list[str]:
        """What the program doubts of the tables. @errors BadInput where it would refuse them; no doubts where it is not built"""
        if not PROGRAM.is_file():
            return []
        beside = f"{self.beside / 'mav0/cam0'}/"
        try:
            return [warning.replace(beside, "") for warning in read_tables(self.beside, self.lens is None)["warnings"]]
        except BadInput as problem:
            raise BadInput(
                f"{self.folder}: polhode would not take it (intrinsics: {self.where}): {str(problem).replace(beside, '')}"
            ) from None

    def finish(self, record: dict) -> dict:
        """@return the record with what the program doubts."""
        self.rows.sort()  # a source's order may be another than that of its times
        self._write_tables(self.rows)
        record = record | {"doubtful": self._asked()}
        (self.beside / "import.json").write_text(
            json.dumps(record | {"frames": len(self.rows), "intrinsics_from": self.where}, indent=2) + "\n"
        )
        for file in self.beside_files:
            shutil.copyfile(file, self.beside / file.name)
        try:
            self.beside.rename(self.folder)  # an empty folder is replaced, what came meanwhile is not
        except OSError as problem:
            raise BadInput(f"{self.folder}: {problem.strerror}") from None
        return record

    def abandon(self) -> None:
        shutil.rmtree(self.beside, ignore_errors=True)


def centred(width_px: int, height_px: int) -> Lens:
    """A lens of unknown focal length: the longer edge is a guess that every estimate begins with."""
    focal_px = float(max(width_px, height_px))
    return Lens(width_px, height_px, (focal_px, focal_px, (width_px - 1) / 2, (height_px - 1) / 2))
