"""Intrinsics of a pinhole camera with radial-tangential distortion (k1, k2, p1, p2) from views of a board.

Source: Zhang, IEEE PAMI 22(11), 2000, by way of OpenCV. Pixel centres at integer coordinates, as everywhere in Polhode.
"""

import dataclasses

import cv2
import numpy

from .boards import View

VIEWS_MIN = 4
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
        board, image, size, None, None, flags=cv2.CALIB_FIX_K3)
    residuals = []
    for view, turn, place in zip(views, turns, places):
        reprojected, _ = cv2.projectPoints(view.board_m, turn, place, matrix, distortion)
        residuals.append(view.image_px - reprojected.reshape(-1, 2))
    sigma = numpy.asarray(sigma).ravel()
    return Calibration(
        width_px=width_px, height_px=height_px,
        intrinsics=numpy.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]),
        distortion=numpy.asarray(distortion).ravel()[:4], sigma_intrinsics=sigma[:4], sigma_distortion=sigma[4:8],
        rms_px=float(rms), views=views, residuals_px=residuals, left_out=[])


def view_rms_px(residuals: numpy.ndarray) -> float:
    return float(numpy.sqrt(numpy.mean(numpy.sum(residuals**2, axis=1))))


def calibrate(views: list[View], width_px: int, height_px: int) -> Calibration:
    """Leaves views out that do not fit the others, and solves once more."""
    if len(views) < VIEWS_MIN:
        raise NotCalibrated(f"the board was found in {len(views)} pictures, at least {VIEWS_MIN} are needed")
    first = solve_once(views, width_px, height_px)
    rms = numpy.array([view_rms_px(r) for r in first.residuals_px])
    good = rms <= max(OUTLIER_RATIO * numpy.median(rms), 0.05)
    if good.all() or good.sum() < VIEWS_MIN:
        return first
    again = solve_once([view for view, fits in zip(views, good) if fits], width_px, height_px)
    again.left_out = [view.name for view, fits in zip(views, good) if not fits]
    return again


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
