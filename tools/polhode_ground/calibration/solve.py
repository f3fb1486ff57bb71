"""Intrinsics of a pinhole camera with radial-tangential distortion (k1, k2, p1, p2) from views of a board.

Source: Zhang, IEEE PAMI 22(11), 2000, by way of OpenCV. Pixel centres at integer coordinates, as everywhere in Polhode.
"""

import dataclasses

import cv2
import numpy

from .boards import View

VIEWS_MIN = 5
# Views whose corners lie closer than this in the mean are one view: the camera did not move between them.
SAME_VIEW_PX = 1.0
# Between the boards' normals of two views. Below it the focal length can be exchanged for the distance.
TILT_MIN_DEG = 20.0
# Part of the picture in which corners were seen. Below it the distortion is free elsewhere.
COVERED_MIN = 0.15
# Of the focal length, 1 sigma over its value. Views that leave more open say little.
FOCAL_SIGMA_MAX = 0.02
RESAMPLES = 24  # of the views: a sigma is then known to 15 %
# What `polhode replay` takes (config/default.toml, [camera]).
RANGES = {
    "fu": (10.0, 1e6),
    "fv": (10.0, 1e6),
    "cu": (-8192.0, 16384.0),
    "cv": (-8192.0, 16384.0),
    "k1": (-10.0, 10.0),
    "k2": (-100.0, 100.0),
    "p1": (-1.0, 1.0),
    "p2": (-1.0, 1.0),
}
# A view whose RMS is so many times the median of all has a wrong corner or moved while it was taken.
OUTLIER_RATIO = 3.0


class NotCalibrated(Exception):
    """The views do not determine the camera."""


@dataclasses.dataclass
class Calibration:
    width_px: int
    height_px: int
    intrinsics: numpy.ndarray  # fu, fv, cu, cv [px]
    distortion: numpy.ndarray  # k1, k2, p1, p2
    sigma_intrinsics: numpy.ndarray
    sigma_distortion: numpy.ndarray
    rms_px: float
    views: list[View]
    residuals_px: list[numpy.ndarray]  # per view, N x 2: seen less reprojected
    left_out: list[str]
    normals: numpy.ndarray  # of the board in the camera, per view, N x 3

    def covered(self) -> float:
        """Part of a 8 x 6 grid over the picture that holds a corner."""
        points = numpy.concatenate([view.image_px for view in self.views])
        u = numpy.clip((points[:, 0] / self.width_px * 8).astype(int), 0, 7)
        v = numpy.clip((points[:, 1] / self.height_px * 6).astype(int), 0, 5)
        return len(set(zip(u, v))) / 48.0


def solve_once(views: list[View], width_px: int, height_px: int) -> Calibration:
    size = (width_px, height_px)
    board = [view.board_m.astype(numpy.float32) for view in views]
    image = [view.image_px.astype(numpy.float32).reshape(-1, 1, 2) for view in views]
    rms, matrix, distortion, turns, places, sigma, _, _ = cv2.calibrateCameraExtended(
        board, image, size, None, None, flags=cv2.CALIB_FIX_K3
    )
    residuals = []
    for view, turn, place in zip(views, turns, places):
        reprojected, _ = cv2.projectPoints(view.board_m, turn, place, matrix, distortion)
        residuals.append(view.image_px - reprojected.reshape(-1, 2))
    sigma = numpy.asarray(sigma).ravel()
    return Calibration(
        width_px=width_px,
        height_px=height_px,
        intrinsics=numpy.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]),
        distortion=numpy.asarray(distortion).ravel()[:4],
        sigma_intrinsics=sigma[:4],
        sigma_distortion=sigma[4:8],
        rms_px=float(rms),
        views=views,
        residuals_px=residuals,
        left_out=[],
        normals=numpy.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns]),
    )


def view_rms_px(residuals: numpy.ndarray) -> float:
    return float(numpy.sqrt(numpy.mean(numpy.sum(residuals**2, axis=1))))


def distinct(views: list[View]) -> list[View]:
    """Without those that repeat another one: they would only seem to know more."""
    kept: list[View] = []
    for view in views:
        same = (
            other
            for other in kept
            if view.board_m.shape == other.board_m.shape
            and numpy.array_equal(view.board_m, other.board_m)
            and numpy.mean(numpy.linalg.norm(view.image_px - other.image_px, axis=1)) < SAME_VIEW_PX
        )
        if next(same, None) is None:
            kept.append(view)
    return kept


def widest_tilt_deg(normals: numpy.ndarray) -> float:
    return float(numpy.degrees(numpy.arccos(numpy.clip(normals @ normals.T, -1.0, 1.0).min())))


def missing(calibration: Calibration) -> list[str]:
    """What the views do not have that a camera needs."""
    told = []
    tilt = widest_tilt_deg(calibration.normals)
    if tilt < TILT_MIN_DEG:
        told.append(
            f"tilts: the boards differ by {tilt:.0f} deg at most, at least {TILT_MIN_DEG:.0f} are needed; tilt by 30 to 45 deg in all directions"
        )
    if calibration.covered() < COVERED_MIN:
        told.append(
            f"coverage: corners cover {100 * calibration.covered():.0f} % of the picture, at least {100 * COVERED_MIN:.0f} are needed"
        )
    return told


def bootstrap(calibration: Calibration) -> tuple[numpy.ndarray, numpy.ndarray]:
    """1 sigma of intrinsics and distortion from the views drawn anew, with repeats (Efron, 1979): what is common to the corners of
    a view is not averaged away, as it is in the sigmas of a fit."""
    random = numpy.random.default_rng(1)
    size = (calibration.width_px, calibration.height_px)
    matrix = numpy.eye(3)
    matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2] = calibration.intrinsics
    found = []
    for _ in range(RESAMPLES):
        drawn = [calibration.views[i] for i in random.integers(0, len(calibration.views), len(calibration.views))]
        _, camera, distortion, _, _ = cv2.calibrateCamera(
            [view.board_m.astype(numpy.float32) for view in drawn],
            [view.image_px.astype(numpy.float32).reshape(-1, 1, 2) for view in drawn],
            size,
            matrix.copy(),
            numpy.append(calibration.distortion, 0.0),
            flags=cv2.CALIB_FIX_K3 | cv2.CALIB_USE_INTRINSIC_GUESS,
        )
        found.append([camera[0, 0], camera[1, 1], camera[0, 2], camera[1, 2], *numpy.ravel(distortion)[:4]])
    # By quartiles: a draw of few different views may have no solution near this one.
    low, high = numpy.percentile(found, [25, 75], axis=0)
    sigma = (high - low) / 1.349
    return sigma[:4], sigma[4:]


def check_ranges(calibration: Calibration) -> None:
    for name, value in zip(RANGES, (*calibration.intrinsics, *calibration.distortion)):
        low, high = RANGES[name]
        if not low <= value <= high:
            raise NotCalibrated(
                f"the views do not determine the camera: {name} = {value:.4g}, which is beyond what a replay takes, {low:g} .. {high:g}"
            )


def fitted(views: list[View], width_px: int, height_px: int) -> Calibration:
    """Leaves views out that do not fit the others, and solves once more."""
    first = solve_once(views, width_px, height_px)
    rms = numpy.array([view_rms_px(r) for r in first.residuals_px])
    good = rms <= max(OUTLIER_RATIO * numpy.median(rms), 0.05)
    if good.all() or good.sum() < VIEWS_MIN:
        return first
    again = solve_once([view for view, fits in zip(views, good) if fits], width_px, height_px)
    again.left_out = [view.name for view, fits in zip(views, good) if not fits]
    return again


def calibrate(views: list[View], width_px: int, height_px: int) -> Calibration:
    """@raises NotCalibrated saying what is missing."""
    different = distinct(views)
    if len(different) < VIEWS_MIN:
        repeated = f", {len(views) - len(different)} of them from where another was taken" if len(different) < len(views) else ""
        raise NotCalibrated(f"the board was found in {len(views)} pictures{repeated}; at least {VIEWS_MIN} different ones are needed")
    calibration = fitted(different, width_px, height_px)
    told = missing(calibration)
    if told:
        raise NotCalibrated("the views do not determine the camera; missing are " + "; ".join(told))
    check_ranges(calibration)
    sigma_intrinsics, sigma_distortion = bootstrap(calibration)
    calibration.sigma_intrinsics = numpy.maximum(calibration.sigma_intrinsics, sigma_intrinsics)
    calibration.sigma_distortion = numpy.maximum(calibration.sigma_distortion, sigma_distortion)
    relative = float((calibration.sigma_intrinsics[:2] / calibration.intrinsics[:2]).max())
    if relative > FOCAL_SIGMA_MAX:
        raise NotCalibrated(
            f"the views leave the focal length open by {100 * relative:.1f} %, at most {100 * FOCAL_SIGMA_MAX:.0f} are allowed: "
            "tilt the board by 30 to 45 deg, in all parts of the picture"
        )
    return calibration


def warnings(calibration: Calibration) -> list[str]:
    """What makes the result less than it looks."""
    told = []
    relative = calibration.sigma_intrinsics[:2] / calibration.intrinsics[:2]
    if relative.max() > 2e-3:
        told.append(f"the focal length is known to {100 * relative.max():.2f} % only: tilt the board more, by 30 to 45 deg")
    if calibration.covered() < 0.6:
        told.append(f"corners cover {100 * calibration.covered():.0f} % of the picture only: distortion is guessed elsewhere")
    if calibration.rms_px > 0.5:
        told.append(f"the RMS residual is {calibration.rms_px:.2f} px: is the board flat, are the pictures sharp?")
    return told
