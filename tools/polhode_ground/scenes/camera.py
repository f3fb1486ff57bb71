"""Pinhole camera with radial-tangential distortion, and the rendering windows that serve it.

Pixel centres are at integer coordinates: the top-left pixel's centre is (0, 0).
C is x right, y down, z forward.
"""

from dataclasses import dataclass

import numpy as np

UNDISTORT_ITERATIONS = 30


@dataclass(frozen=True)
class Camera:
    """Intrinsics in px; distortion (k1, k2, p1, p2) as in the Brown-Conrady model."""

    width: int
    height: int
    fu: float
    fv: float
    cu: float
    cv: float
    distortion: tuple = (0.0, 0.0, 0.0, 0.0)

    @property
    def is_plain(self):
        """True if a square-pixel pinhole renders this camera without resampling."""
        return not any(self.distortion) and self.fu == self.fv


def distort(xy, distortion):
    """Normalised ideal coordinates (..., 2) to normalised distorted ones."""
    k1, k2, p1, p2 = distortion
    x, y = xy[..., 0], xy[..., 1]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    return np.stack(
        [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y],
        axis=-1,
    )


def undistort(xy_distorted, distortion):
    """Inverse of distort by fixed-point iteration."""
    xy = np.array(xy_distorted, dtype=float)
    for _ in range(UNDISTORT_ITERATIONS):
        xy = xy + (xy_distorted - distort(xy, distortion))
    return xy


def project(camera, p_C):
    """Pixel coordinates (..., 2) of points in C (..., 3) with z > 0."""
    xy = distort(p_C[..., :2] / p_C[..., 2:3], camera.distortion)
    return xy * [camera.fu, camera.fv] + [camera.cu, camera.cv]


def pixel_rays(camera, u, v):
    """Normalised ideal coordinates (..., 2) of the rays through pixels (u, v)."""
    xy = np.stack([(u - camera.cu) / camera.fu, (v - camera.cv) / camera.fv], axis=-1)
    return undistort(xy, camera.distortion) if any(camera.distortion) else xy


def scene_margin_is_invertible(camera):
    """True if the distortion is one-to-one over the whole image (no fold-over before the corners)."""
    if not any(camera.distortion):
        return True
    u, v = np.meshgrid(np.linspace(0, camera.width - 1, 40), np.linspace(0, camera.height - 1, 40))
    # Where the model folds over, the iteration runs away; that is an answer, too.
    with np.errstate(over="ignore", invalid="ignore"):
        xy = pixel_rays(camera, u, v)
    if not np.all(np.isfinite(xy)):
        return False
    back = distort(xy, camera.distortion) * [camera.fu, camera.fv] + [camera.cu, camera.cv]
    return bool(np.abs(back - np.stack([u, v], axis=-1)).max() < 1e-3)


class Resampler:
    """Takes ideal square-pixel renderings to the camera's own pixels.

    The ideal image has focal length f_ideal (px) and principal point (cu, cv); the map gives, for each camera
    pixel, the ideal pixel to read. For a plain camera the map is the identity and nothing is resampled.
    """

    def __init__(self, camera):
        self.camera = camera
        self.f_ideal = max(camera.fu, camera.fv)
        u, v = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
        self.map_uv = None
        if not camera.is_plain:
            self.map_uv = pixel_rays(camera, u, v) * self.f_ideal + [camera.cu, camera.cv]

    def full_window(self):
        """(x0, y0, width, height) in ideal pixels that covers the whole camera image."""
        if self.map_uv is None:
            return 0, 0, self.camera.width, self.camera.height
        low = np.floor(self.map_uv.min(axis=(0, 1))).astype(int) - 3
        high = np.ceil(self.map_uv.max(axis=(0, 1))).astype(int) + 4
        return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])

    def target_window(self, p_C, margin_px=4):
        """Smallest ideal window with the points p_C (N, 3), clipped to full_window; None if empty."""
        x0, y0, width, height = self.full_window()
        front = p_C[p_C[:, 2] > 1e-6]
        if len(front) < len(p_C):
            return x0, y0, width, height
        uv = front[:, :2] / front[:, 2:3] * self.f_ideal + [self.camera.cu, self.camera.cv]
        low = np.maximum(np.floor(uv.min(axis=0)).astype(int) - margin_px, [x0, y0])
        high = np.minimum(np.ceil(uv.max(axis=0)).astype(int) + margin_px + 1, [x0 + width, y0 + height])
        if np.any(high - low < 1):
            return None
        return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])

    def to_camera(self, window_image, window):
        """Camera image (H, W, channels) from an ideal rendering of a window; zero outside it."""
        camera = self.camera
        channels = window_image.shape[2]
        out = np.zeros((camera.height, camera.width, channels), dtype=np.float32)
        x0, y0, width, height = window
        if self.map_uv is None:
            out[y0 : y0 + height, x0 : x0 + width] = window_image
            return out
        local = self.map_uv - [x0, y0]
        inside = (local[..., 0] >= 0) & (local[..., 0] <= width - 1)
        inside &= (local[..., 1] >= 0) & (local[..., 1] <= height - 1)
        out[inside] = sample_cubic(window_image, local[inside])
        return out


def share_samples(image):
    """image (H, W, channels) whose pixels are means over their own squares, as if seen through Blender's usual filter.

    That filter, Blackman-Harris 3 px wide, has the variance 0.173 px^2, a square's is 0.083: the weight 1/20 for each
    of two neighbours adds 0.1, an axis at a time. Since the neighbours' samples count too, a picture of 4 samples has the
    noise of one of 8 that were drawn for each pixel on its own.
    """
    wide = np.pad(image, ((1, 1), (1, 1), (0, 0)), mode="edge")
    rows = 0.9 * wide[1:-1] + 0.05 * (wide[:-2] + wide[2:])
    return 0.9 * rows[:, 1:-1] + 0.05 * (rows[:, :-2] + rows[:, 2:])


def _cubic_weights(t):
    """Catmull-Rom weights (4, N) for fractions t in [0, 1)."""
    t2, t3 = t * t, t * t * t
    return np.stack([-0.5 * t + t2 - 0.5 * t3, 1 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3]).astype(
        np.float32
    )


def sample_cubic(image, uv):
    """Catmull-Rom samples (N, channels) of an image (H, W, channels) at pixel coordinates uv (N, 2)."""
    height, width = image.shape[:2]
    base = np.floor(uv).astype(np.int64)
    wx = _cubic_weights(uv[:, 0] - base[:, 0])
    wy = _cubic_weights(uv[:, 1] - base[:, 1])
    out = np.zeros((len(uv), image.shape[2]), dtype=np.float32)
    for j in range(4):
        rows = np.clip(base[:, 1] + j - 1, 0, height - 1)
        line = np.zeros_like(out)
        for i in range(4):
            cols = np.clip(base[:, 0] + i - 1, 0, width - 1)
            line += wx[i][:, None] * image[rows, cols]
        out += wy[j][:, None] * line
    return out
