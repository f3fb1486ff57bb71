"""The lens of ROS' CameraInfo: K and the distortion are of the whole sensor, pictures are of a region of it, or of pixels taken together."""

from dataclasses import dataclass, replace

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.lens import Lens, lens_of

# The principal point of lenses is near the middle, in shares of the picture's side. Beyond this K is of another picture than it says,
# if it is nearer the middle of the picture that was read out.
OFF_CENTRE_MAX = 0.1


@dataclass(frozen=True)
class Readout:
    """A region of the sensor in its own pixels, of which binning makes one of several."""

    x: int
    y: int
    width: int
    height: int
    bin_x: int
    bin_y: int

    @property
    def words(self) -> str:
        return f"roi {self.width}x{self.height} at ({self.x}, {self.y}), binning {self.bin_x}x{self.bin_y}"


def field(info, name: str, default=0):
    """Of a message or of a table that was printed of one. ROS 1 writes K, D and P where ROS 2 writes k, d and p."""
    for spelled in (name, name.upper()):
        found = info.get(spelled) if isinstance(info, dict) else getattr(info, spelled, None)
        if found is not None:
            return found
    return default


def numbers_of(info) -> list:
    """All that the lens is made of, to compare."""
    numbers = [value for name in ("width", "height", "k", "d", "p") for value in np.ravel(field(info, name))]
    return [*numbers, readout_of(info, int(field(info, "width")), int(field(info, "height")))]


def readout_of(info, width: int, height: int) -> Readout:
    roi = field(info, "roi", {})
    x, y, roi_width, roi_height = (int(field(roi, name)) for name in ("x_offset", "y_offset", "width", "height"))
    bins = (max(1, int(field(info, name))) for name in ("binning_x", "binning_y"))
    return Readout(x, y, roi_width or width - x, roi_height or height - y, *bins)


def lens_of_info(info, rectified: bool, where: str) -> Lens:
    """@param rectified  the pictures are: P holds for them, and nothing is distorted"""
    width, height = int(field(info, "width")), int(field(info, "height"))
    matrix = np.ravel(field(info, "p" if rectified else "k", ()))
    if len(matrix) != (12 if rectified else 9):
        raise BadInput(f"{where}: {'P' if rectified else 'K'} has {len(matrix)} numbers, needed are {12 if rectified else 9}")
    numbers = matrix[[0, 5, 2, 6]] if rectified else matrix[[0, 4, 2, 5]]
    model, coefficients = ("none", ()) if rectified else (str(field(info, "distortion_model", "")), field(info, "d", ()))
    lens = lens_of(width, height, numbers, model, coefficients, where)
    read = readout_of(info, width, height)
    if read == Readout(0, 0, width, height, 1, 1):
        return lens if width and height else replace(lens, notes=(f"{where} tells no size: it is taken to be of these pictures",))
    return _read_out(lens, read, where)


def _read_out(lens: Lens, read: Readout, where: str) -> Lens:
    fu, fv, cu, cv = lens.intrinsics_px
    width, height = read.width // read.bin_x, read.height // read.bin_y
    advice = "give --intrinsics FILE or 'fu,fv,cu,cv' of the pictures themselves"
    said = f"{read.words} of {lens.width_px}x{lens.height_px}"
    if read.x + read.width > lens.width_px or read.y + read.height > lens.height_px or min(width, height) < 1:
        raise BadInput(f"{where}: {said}: the region is not within the sensor; {advice}")
    of_sensor, of_picture = _off_centre(lens, lens.width_px, lens.height_px), _off_centre(lens, width, height)
    if of_sensor > OFF_CENTRE_MAX and of_picture < of_sensor:
        raise BadInput(
            f"{where}: {said}, but the principal point ({cu:g}, {cv:g}) is near the middle of the picture read out, not of the sensor: "
            f"which of them K is of is not clear; {advice}"
        )
    numbers = (fu / read.bin_x, fv / read.bin_y, (cu - read.x + 0.5) / read.bin_x - 0.5, (cv - read.y + 0.5) / read.bin_y - 0.5)
    note = f"{where}: {said}: intrinsics {', '.join(f'{value:.6g}' for value in numbers)}"
    return replace(lens, width_px=width, height_px=height, intrinsics_px=numbers, notes=(note,), size_from=said)


def _off_centre(lens: Lens, width: int, height: int) -> float:
    cu, cv = lens.intrinsics_px[2:]
    return max(abs(cu - (width - 1) / 2) / width, abs(cv - (height - 1) / 2) / height)
