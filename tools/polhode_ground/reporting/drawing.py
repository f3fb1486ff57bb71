"""A target's outline and axes drawn over a picture."""

import cv2
import numpy as np

AXIS_BGR = ((39, 39, 214), (44, 160, 44), (180, 119, 31))
OUTLINE_BGR = (0, 200, 255)


def project_points(camera, R_CT, p_CT, points_T: np.ndarray) -> np.ndarray:
    """[N,2] pixels of those of the points that are before the camera."""
    pixels = camera.project(R_CT.apply(points_T) + p_CT)
    return pixels[np.isfinite(pixels).all(axis=1)]


def draw_target(picture: np.ndarray, camera, R_CT, p_CT, points_T: np.ndarray, origin_T: np.ndarray, axes_T: np.ndarray) -> None:
    """@param picture  [H,W,3] in BGR, changed. @param points_T  [N,3] on the body: their hull is the outline.
    @param axes_T  [3,3], a row an axis, as long as it is drawn from origin_T."""
    thick = max(1, round(camera.width_px / 500))
    pixels = project_points(camera, R_CT, p_CT, points_T).clip(-10000, 10000)
    if len(pixels) >= 3:
        cv2.polylines(picture, [cv2.convexHull(pixels.round().astype(np.int32))], True, OUTLINE_BGR, thick, cv2.LINE_AA)
    for direction, colour in zip(axes_T, AXIS_BGR):
        ends = project_points(camera, R_CT, p_CT, np.array([origin_T, origin_T + direction]))
        if len(ends) == 2:
            a, b = (tuple(int(value) for value in end.round().clip(-10000, 10000)) for end in ends)
            cv2.arrowedLine(picture, a, b, colour, 2 * thick, cv2.LINE_AA, tipLength=0.12)
