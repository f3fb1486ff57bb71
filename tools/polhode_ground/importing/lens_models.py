"""Models of lenses: where a direction comes to lie in the plane that fu, fv, cu, cv turn into pixels.

Every model is a function from directions [N,3] (x right, y down, z forward) and coefficients to places [N,2]. A direction that the model
can't project gives NaN. OpenCV projects by its own code, COLMAP's own models by COLMAP's (colmap_library.py).
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from polhode_ground.common.errors import BadInput

RADTAN, FISHEYE = "radial-tangential", "equidistant"
OMNI, DOUBLE_SPHERE, UNIFIED, FOV, PANORAMA = "omnidirectional", "double sphere", "extended unified", "field of view", "equirectangular"


@dataclass(frozen=True)
class Model:
    counts: tuple[int, ...]  # of coefficients that may be given
    project: Callable[[np.ndarray, tuple[float, ...]], np.ndarray]


def _by_opencv(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    import cv2

    none = np.zeros(3)
    return cv2.projectPoints(directions, none, none, np.eye(3), np.array(coefficients))[0].reshape(-1, 2)


def _by_opencv_fisheye(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    import cv2

    none = np.zeros(3)
    return cv2.fisheye.projectPoints(directions[:, None], none, none, np.eye(3), np.array(coefficients))[0].reshape(-1, 2)


def _divided(directions: np.ndarray, divisor: np.ndarray) -> np.ndarray:
    """x and y by the divisor; NaN where it is not positive: that direction is not seen."""
    return directions[:, :2] / np.where(divisor > 1e-9, divisor, np.nan)[:, None]


def _omni(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    """Mei and Rives 2007, as in Kalibr and OpenCV's omnidir: xi, then k1, k2, p1, p2."""
    xi, k1, k2, p1, p2 = coefficients
    plane = _divided(directions, directions[:, 2] + xi * np.linalg.norm(directions, axis=1))
    return _by_opencv(np.column_stack([plane, np.ones(len(plane))]), (k1, k2, p1, p2))


def _double_sphere(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    """Usenko et al. 2018, equations 40 to 42: xi, alpha."""
    xi, alpha = coefficients
    x, y, z = directions.T
    first = np.sqrt(x * x + y * y + z * z)
    second = np.sqrt(x * x + y * y + (xi * first + z) ** 2)
    return _divided(directions, alpha * second + (1 - alpha) * (xi * first + z))


def _unified(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    """Khomutenko et al. 2016: alpha, beta."""
    alpha, beta = coefficients
    x, y, z = directions.T
    return _divided(directions, alpha * np.sqrt(beta * (x * x + y * y) + z * z) + (1 - alpha) * z)


def _fov(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    """Devernay and Faugeras 2001: omega."""
    (omega,) = coefficients
    plane = _divided(directions, directions[:, 2])
    radius = np.linalg.norm(plane, axis=1, keepdims=True)
    if abs(omega) < 1e-8:
        return plane
    slope = 2 * np.tan(omega / 2)
    return plane * np.where(radius > 1e-9, np.arctan(radius * slope) / (np.maximum(radius, 1e-9) * omega), slope / omega)


def _panorama(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    """Longitude and latitude, downwards [rad]."""
    x, y, z = directions.T
    return np.column_stack([np.arctan2(x, z), np.arctan2(y, np.hypot(x, z))])


def _by_colmap(name: str) -> Callable[[np.ndarray, tuple[float, ...]], np.ndarray]:
    def project(directions: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
        from polhode_ground.importing.colmap_library import project as by_library

        return by_library(name, coefficients, directions)

    return project


# COLMAP's models that only its own library projects, with how many coefficients they have.
COLMAP_MODELS = {"THIN_PRISM_FISHEYE": 8, "RAD_TAN_THIN_PRISM_FISHEYE": 12, "DIVISION": 1}
MODELS = {
    RADTAN: Model((0, 4, 5, 8, 12, 14), _by_opencv),
    FISHEYE: Model((0, 4), _by_opencv_fisheye),
    OMNI: Model((5,), _omni),
    DOUBLE_SPHERE: Model((2,), _double_sphere),
    UNIFIED: Model((2,), _unified),
    FOV: Model((1,), _fov),
    PANORAMA: Model((0,), _panorama),
    **{f"COLMAP's {name}": Model((count,), _by_colmap(name)) for name, count in COLMAP_MODELS.items()},
}


def _plain(name: str) -> str:
    return re.sub("[^a-z0-9]", "", name.lower())


# As OpenCV, ROS, Kalibr, EuRoC and drivers of cameras write them; only letters and digits are compared.
NAMES = {_plain(name): name for name in MODELS} | {
    "": RADTAN,
    "none": RADTAN,
    "pinhole": RADTAN,
    "opencv": RADTAN,
    "opencvfisheye": FISHEYE,
    "radtan": RADTAN,
    "plumbbob": RADTAN,
    "rationalpolynomial": RADTAN,
    "thinprism": RADTAN,
    "brownconrady": RADTAN,
    "equi": FISHEYE,
    "fisheye": FISHEYE,
    "kannalabrandt": FISHEYE,
    "kannalabrandt4": FISHEYE,
    "kannalabrandt8": FISHEYE,
    "kb4": FISHEYE,
    "kb8": FISHEYE,
    "fov": FOV,
    "omni": OMNI,
    "mei": OMNI,
    "ds": DOUBLE_SPHERE,
    "eucm": UNIFIED,
}
SAID = "radtan, plumb_bob, rational_polynomial, thin_prism, equidistant, fisheye, fov, omni, ds, eucm, none"


def model_named(name: str, where: str) -> str:
    if _plain(name) not in NAMES:
        raise BadInput(f"{where}: distortion model '{name}', allowed are {SAID}")
    return NAMES[_plain(name)]
