"""Pictures whose neighbouring pixels differ systematically, as a colour sensor's mosaic in one channel does.

The rules are those of `polhode replay` (platform/camera/replay/mosaic.cpp, which has the reasons).
"""

import numpy as np

CONTRAST_MIN = 0.04
LIT = 1 / 16
TILES = 8
TILE_PIXELS_MIN = 128
TILES_MIN = 4
AGREEING_MIN = 0.75


def without_mosaic(pixels: np.ndarray) -> np.ndarray:
    """Each pixel the mean of what is around it, 1-2-1 both ways: any pattern of 2x2 pixels gives its mean."""
    import cv2

    return np.floor(_smooth(pixels) + 0.5).astype(pixels.dtype) if pixels.dtype.kind in "ui" else cv2.sepFilter2D(pixels, -1, *_KERNELS)


_KERNELS = (np.array([0.25, 0.5, 0.25]), np.array([0.25, 0.5, 0.25]))


def _smooth(pixels: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.sepFilter2D(pixels.astype(np.float64), cv2.CV_64F, *_KERNELS)


def contrast_of(pixels: np.ndarray) -> float:
    """By which share of the level the cells of 2x2 pixels differ; 0 where they do not, or not alike all over the picture."""
    height, width = (size // TILES // 2 * 2 for size in pixels.shape)
    if min(height, width) < 2:
        return 0.0
    part = slice(0, TILES * height), slice(0, TILES * width)
    mean = _smooth(pixels)
    lit = (mean > LIT * pixels.max(initial=0))[part]
    sums = [
        np.where(lit, image[part], 0.0)
        .reshape(TILES, height // 2, 2, TILES, width // 2, 2)
        .sum(axis=(1, 4))
        .transpose(0, 2, 1, 3)
        .reshape(-1, 4)
        for image in (pixels - mean, mean)
    ]
    count = lit.reshape(TILES, height, TILES, width).sum(axis=(1, 3)).ravel()
    used = count >= TILE_PIXELS_MIN
    if used.sum() < TILES_MIN:
        return 0.0
    cells = sums[0][used].sum(axis=0) / sums[1][used].sum(axis=0)
    brightest, darkest = int(np.argmax(cells)), int(np.argmin(cells))
    agreeing = np.mean(sums[0][used][:, brightest] > sums[0][used][:, darkest])
    contrast = float(cells[brightest] - cells[darkest])
    return contrast if contrast >= CONTRAST_MIN and agreeing >= AGREEING_MIN else 0.0
