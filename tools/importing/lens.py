"""Cameras as calibrations give them, and the one that `polhode` knows: pinhole with k1, k2, p1, p2.

Other distortions are taken out of the pictures. Pixel centres are at integer coordinates, as in OpenCV, Kalibr and ROS.
"""

from dataclasses import dataclass, replace

import numpy as np

from judge.errors import BadInput

RADTAN, FISHEYE = "radial-tangential", "equidistant"


@dataclass(frozen=True)
class Lens:
    """Intrinsics fu, fv, cu, cv [px] of pictures of this size; coefficients in OpenCV's order for either model."""

    width_px: int
    height_px: int
    intrinsics_px: tuple[float, float, float, float]
    model: str = RADTAN
    coefficients: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)

    @property
    def matrix(self) -> np.ndarray:
        fu, fv, cu, cv = self.intrinsics_px
        return np.array([[fu, 0.0, cu], [0.0, fv, cv], [0.0, 0.0, 1.0]])

    @property
    def native(self) -> bool:
        """`polhode` can read it as it is."""
        return self.model == RADTAN and not any(self.coefficients[4:])


def lens_of(width_px, height_px, intrinsics, model: str, coefficients, where: str) -> Lens:
    """A checked lens; the name of the model may be that of OpenCV, ROS, Kalibr or EuRoC."""
    names = {"radtan": RADTAN, "radial-tangential": RADTAN, "plumb_bob": RADTAN, "rational_polynomial": RADTAN, "none": RADTAN, "": RADTAN,
             "equidistant": FISHEYE, "fisheye": FISHEYE}
    if model not in names:
        raise BadInput(f"{where}: distortion model '{model}', allowed are {', '.join(name for name in names if name)}")
    try:
        fu, fv, cu, cv = (float(value) for value in intrinsics)
        values = tuple(float(value) for value in np.ravel(coefficients))
    except (TypeError, ValueError):
        raise BadInput(f"{where}: intrinsics {intrinsics}, needed are fu, fv, cu, cv and the distortion as numbers") from None
    allowed = (0, 4) if names[model] == FISHEYE else (0, 4, 5, 8, 12, 14)
    if len(values) not in allowed:
        raise BadInput(f"{where}: {len(values)} distortion coefficients for '{model}', allowed are {', '.join(map(str, allowed))}")
    if not all(np.isfinite((fu, fv, cu, cv, *values))) or min(fu, fv) <= 0:
        raise BadInput(f"{where}: intrinsics {fu:g}, {fv:g}, {cu:g}, {cv:g}: focal lengths must be positive")
    return Lens(int(width_px), int(height_px), (fu, fv, cu, cv), names[model], values or (0.0,) * 4)


def scaled_to(lens: Lens, width_px: int, height_px: int, where: str) -> tuple[Lens, str]:
    """The lens for pictures of another size of the same shape, and what was assumed (empty where the sizes agree)."""
    if (lens.width_px, lens.height_px) in ((width_px, height_px), (0, 0)):
        return replace(lens, width_px=width_px, height_px=height_px), ""
    found = f"{where}: calibrated for {lens.width_px}x{lens.height_px}, but the pictures are {width_px}x{height_px}"
    factor = width_px / lens.width_px
    if abs(factor * lens.height_px - height_px) > 1.0:
        turned = (lens.height_px, lens.width_px) == (width_px, height_px)
        raise BadInput(f"{found}: {'the pictures are turned by 90 deg' if turned else 'not the same shape, cropped?'}")
    fu, fv, cu, cv = lens.intrinsics_px
    centre = (factor * (cu + 0.5) - 0.5, factor * (cv + 0.5) - 0.5)
    return (replace(lens, width_px=width_px, height_px=height_px, intrinsics_px=(factor * fu, factor * fv, *centre)),
            f"{found}: intrinsics scaled by {factor:.4g}")


class Undistorter:
    """Takes a lens' distortion out of pictures; the result has the lens' own focal length, enlarged so that no edge is empty."""

    def __init__(self, lens: Lens):
        import cv2
        size = (lens.width_px, lens.height_px)
        coefficients = np.array(lens.coefficients)
        if lens.model == FISHEYE:
            # Angles from 80 deg on have no place in a plane: what is kept is decided by OpenCV's balance 0.
            matrix = cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(lens.matrix, coefficients, size, np.eye(3), balance=0.0)
            self._maps = cv2.fisheye.initUndistortRectifyMap(lens.matrix, coefficients, np.eye(3), matrix, size, cv2.CV_32FC1)
        else:
            matrix, _ = cv2.getOptimalNewCameraMatrix(lens.matrix, coefficients, size, 0.0)
            self._maps = cv2.initUndistortRectifyMap(lens.matrix, coefficients, None, matrix, size, cv2.CV_32FC1)
        self.lens = Lens(*size, (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]))

    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        import cv2
        return cv2.remap(pixels, *self._maps, cv2.INTER_CUBIC)
