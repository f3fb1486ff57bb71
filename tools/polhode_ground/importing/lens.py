"""Cameras as calibrations give them, and the one that `polhode` knows: pinhole with k1, k2, p1, p2.

Other distortions are taken out of the pictures (undistorting.py). Pixel centres are at integer coordinates, as in OpenCV, Kalibr and ROS.
"""

from dataclasses import dataclass, replace

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.lens_models import MODELS, RADTAN, model_named

SAME_RATIO = 0.05  # fu / fv of a calibration and the shape of the pixels agree to this; calibrations of square pixels differ by 0.01
RANGE = (10.0, 100.0, 1.0, 1.0)  # of k1, k2, p1, p2 in `polhode`'s table of parameters
SIZE_PX = 1.0  # halves of odd sizes are rounded up by some and down by others


@dataclass(frozen=True)
class Lens:
    """Intrinsics fu, fv, cu, cv [px] of pictures of this size, 0 where it is not known; coefficients in the order of lens_models.py."""

    width_px: int
    height_px: int
    intrinsics_px: tuple[float, float, float, float]
    model: str = RADTAN
    coefficients: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    notes: tuple[str, ...] = ()  # what was chosen or assumed when it was read
    line_time_ns: float = 0.0  # from one row to the next, as the calibration tells it; 0: it does not
    camera: str = ""  # its name in a file of several
    others: tuple[tuple[str, tuple[int, int]], ...] = ()  # the names and sizes of these
    size_from: str = ""  # what fixes the size, so that pictures of another size contradict it; empty: they may be scaled ones

    @property
    def native(self) -> bool:
        """`polhode` can read it as it is. Telephoto lenses have coefficients beyond its range."""
        return (
            self.model == RADTAN
            and not any(self.coefficients[4:])
            and all(abs(value) <= most for value, most in zip(self.coefficients, RANGE))
        )

    @property
    def words(self) -> str:
        return f"radial-tangential with {len(self.coefficients)} coefficients" if self.model == RADTAN else self.model

    def project(self, directions: np.ndarray) -> np.ndarray:
        """Pixels [N,2] of directions [N,3]; NaN where the lens does not see them."""
        fu, fv, cu, cv = self.intrinsics_px
        return MODELS[self.model].project(np.ascontiguousarray(directions, float), self.coefficients) * (fu, fv) + (cu, cv)


def lens_of(width_px, height_px, intrinsics, model: str, coefficients, where: str) -> Lens:
    """A checked lens; the name of the model may be that of OpenCV, ROS, Kalibr or EuRoC."""
    kind = model_named(model, where)
    try:
        fu, fv, cu, cv = (float(value) for value in intrinsics)
        values = tuple(float(value) for value in np.ravel(coefficients))
        width, height = int(float(width_px)), int(float(height_px))
    except (TypeError, ValueError):
        raise BadInput(f"{where}: intrinsics {intrinsics}, needed are fu, fv, cu, cv, the distortion and the size as numbers") from None
    counts = MODELS[kind].counts
    while len(values) > max(counts) and values[-1] == 0:  # drivers fill up with zeros
        values = values[:-1]
    if len(values) not in counts:
        raise BadInput(f"{where}: {len(values)} distortion coefficients for '{model}', allowed are {', '.join(map(str, counts))}")
    if model.lower() == "none" and any(values):
        raise BadInput(f"{where}: distortion model 'none', but coefficients {', '.join(f'{value:g}' for value in values)}: name the model")
    if not all(np.isfinite((fu, fv, cu, cv, *values))):
        raise BadInput(
            f"{where}: intrinsics {fu:g}, {fv:g}, {cu:g}, {cv:g} and coefficients {', '.join(f'{value:g}' for value in values)}: "
            "allowed are finite numbers"
        )
    if len(values) >= 8 and any(values) and all(value == int(value) for value in values):
        raise BadInput(
            f"{where}: coefficients {', '.join(f'{value:g}' for value in values)}, all of them whole numbers: "
            "where commas stand for decimal points, write points"
        )
    if min(fu, fv) <= 0:
        raise BadInput(f"{where}: intrinsics {fu:g}, {fv:g}, {cu:g}, {cv:g}: focal lengths must be positive")
    return Lens(width, height, (fu, fv, cu, cv), kind, values or (0.0,) * (4 if 4 in counts else 0))


def scaled_to(lens: Lens, width_px: int, height_px: int, where: str, aspect: float = 1.0) -> tuple[Lens, str]:
    """The lens for pictures of another size of the same shape, and what was assumed (empty where the sizes agree).

    @param aspect  width by height of a pixel: the calibration may be of pictures that were stretched to square ones
    """
    if (lens.width_px, lens.height_px) in ((width_px, height_px), (0, 0)):
        return replace(lens, width_px=width_px, height_px=height_px), ""
    off_px = max(abs(lens.width_px - width_px), abs(lens.height_px - height_px))
    if lens.size_from and off_px > SIZE_PX:
        raise BadInput(
            f"{where}: {lens.size_from} makes pictures of {lens.width_px}x{lens.height_px}, but they are {width_px}x{height_px}: "
            "give --intrinsics FILE or 'fu,fv,cu,cv' of these pictures"
        )
    found = f"{where}: {lens.camera and f'{lens.camera} is '}calibrated for {lens.width_px}x{lens.height_px}, but the pictures are {width_px}x{height_px}"
    fitting = [name for name, size in lens.others if size == (width_px, height_px)]
    choice = (
        f"{' and '.join(fitting)} of the same file {'is' if len(fitting) == 1 else 'are'} of this size: --camera {fitting[0]} takes it"
        if fitting
        else ""
    )
    factors = width_px / lens.width_px, height_px / lens.height_px
    stretched = aspect != 1 and abs(factors[1] * lens.width_px - width_px * aspect) <= SIZE_PX * aspect
    if abs(factors[0] * lens.height_px - height_px) > SIZE_PX and not stretched:
        turned = (lens.height_px, lens.width_px) == (width_px, height_px)
        why = (
            "width and height are exchanged: in the calibration, or by pictures that are turned by 90 deg"
            if turned
            else "not the same shape, cropped?"
        )
        raise BadInput(f"{found}: {choice or why}")
    fu, fv, cu, cv = lens.intrinsics_px
    centre = tuple(factor * (place + 0.5) - 0.5 for factor, place in zip(factors, (cu, cv)))
    by = f"{factors[0]:.4g}" if not stretched else f"{factors[0]:.4g} and {factors[1]:.4g}, by the shape of the pixels"
    return (
        replace(
            lens,
            width_px=width_px,
            height_px=height_px,
            intrinsics_px=(factors[0] * fu, factors[1] * fv, *centre),
            line_time_ns=lens.line_time_ns / factors[1],
        ),
        f"{found}: intrinsics scaled by {by}{choice and f'; {choice}'}",
    )


def has_shape(lens: Lens | None, aspect: float) -> bool:
    """Whether fu and fv say so of the pixels, too, as far as they are known."""
    return lens is None or abs(aspect * lens.intrinsics_px[0] / lens.intrinsics_px[1] - 1) <= SAME_RATIO


def shape_of_pixels(lens: Lens | None, aspect: float) -> str:
    """What is to be said where the source tells that its pixels are no squares; empty where they are."""
    if aspect == 1:
        return ""
    said = f"the source says that its pixels are {aspect:.4g} times as wide as high"
    if lens is None:
        return f"{said}: fu / fv is taken to be {1 / aspect:.4g}"
    if has_shape(lens, aspect):
        return f"{said}, and so do the intrinsics"
    ratio = lens.intrinsics_px[0] / lens.intrinsics_px[1]
    return f"{said}, but fu / fv of the intrinsics is {ratio:.4g} in place of {1 / aspect:.4g}: the intrinsics are followed"
