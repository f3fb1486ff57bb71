"""Procedural noise for textures. All images are (H, W) float32, row 0 at v = 0 (the bottom); seeded, repeatable."""

import numpy as np


def generator(*key):
    """Counter-based random generator for a tuple of non-negative integers."""
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(list(key))))


def resize(image, shape):
    """Bilinear resize of (h, w) to shape; samples are at cell centres."""
    h, w = image.shape
    y = np.clip((np.arange(shape[0]) + 0.5) * h / shape[0] - 0.5, 0, h - 1)
    x = np.clip((np.arange(shape[1]) + 0.5) * w / shape[1] - 0.5, 0, w - 1)
    y0, x0 = np.minimum(y.astype(int), max(h - 2, 0)), np.minimum(x.astype(int), max(w - 2, 0))
    fy, fx = (y - y0).astype(np.float32)[:, None], (x - x0).astype(np.float32)[None, :]
    y1, x1 = np.minimum(y0 + 1, h - 1), np.minimum(x0 + 1, w - 1)
    rows = image[y0] * (1 - fy) + image[y1] * fy
    return (rows[:, x0] * (1 - fx) + rows[:, x1] * fx).astype(np.float32)


def fractal(shape, rng, beta=2.0, scale_px=None):
    """Noise with a power spectrum of frequency^-beta, mean 0, deviation 1.

    scale_px: wavelengths longer than this are damped, so that large images do not get one big blotch.
    """
    size = [max(8, s) for s in shape]
    white = rng.standard_normal(size).astype(np.float32)
    fy = np.fft.fftfreq(size[0])[:, None]
    fx = np.fft.rfftfreq(size[1])[None, :]
    frequency = np.sqrt(fy * fy + fx * fx)
    lowest = 1.0 / (scale_px or max(size))
    gain = 1.0 / (frequency**2 + lowest**2) ** (beta / 4)
    gain[0, 0] = 0
    out = np.fft.irfft2(np.fft.rfft2(white) * gain, s=size)[: shape[0], : shape[1]]
    return ((out - out.mean()) / (out.std() + 1e-9)).astype(np.float32)


def facets(shape, cell_px, rng):
    """Worley cells of about cell_px: returns (id, edge), id int (H, W), edge = F2 - F1 in cells (0 on creases)."""
    h, w = shape
    ny, nx = int(h / cell_px) + 3, int(w / cell_px) + 3
    jitter = rng.random((ny, nx, 2)).astype(np.float32)
    y = (np.arange(h, dtype=np.float32) / cell_px + 1)[:, None]
    x = (np.arange(w, dtype=np.float32) / cell_px + 1)[None, :]
    iy, ix = y.astype(int), x.astype(int)
    first = np.full((h, w), 9.0, dtype=np.float32)
    second = np.full((h, w), 9.0, dtype=np.float32)
    ids = np.zeros((h, w), dtype=np.int32)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            cy, cx = iy + dy, ix + dx
            point = jitter[cy, cx]
            d = (cy + point[..., 0] - y) ** 2 + (cx + point[..., 1] - x) ** 2
            closer = d < first
            second = np.where(closer, first, np.minimum(second, d))
            ids = np.where(closer, cy * nx + cx, ids)
            first = np.where(closer, d, first)
    return ids, np.sqrt(second) - np.sqrt(first)


def facet_slopes(shape, cell_px, rng, deviation):
    """Slopes (sx, sy) of a surface of flat facets, as crumpled foil has, plus the crease mask in [0, 1]."""
    # Facets at more than 8 px are made at lower resolution: their edges stay sharper than any rendered pixel.
    reduce = max(1, int(cell_px // 12))
    small = (max(8, shape[0] // reduce), max(8, shape[1] // reduce))
    ids, edge = facets(small, cell_px / reduce, rng)
    table = rng.standard_normal((ids.max() + 1, 2)).astype(np.float32) * deviation
    sx, sy = table[ids, 0], table[ids, 1]
    crease = np.clip(1 - edge / 0.06, 0, 1)
    if reduce > 1:
        sx, sy, crease = resize(sx, shape), resize(sy, shape), resize(crease, shape)
    return sx, sy, crease


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)
