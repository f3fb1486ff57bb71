"""Spacecraft surfaces made of numbers: foil, solar cells, painted plates, bare metal, carbon.

Every function takes the texture's shape (H, W), its density in texels per metre and a seeded generator, and
returns a Material. Detail is laid on at several scales so that something remains to be seen at each range.
"""

import numpy as np

from . import glyphs, noise
from .materials import Material, slopes_from_height

GOLD = (0.96, 0.70, 0.27)
SILVER = (0.86, 0.87, 0.88)


def _canvas(shape, color):
    return np.ones((*shape, 3), dtype=np.float32) * np.asarray(color, dtype=np.float32)


def _paint(image, mask, color):
    """image with color (3,) or a number laid over it where mask (H, W) is 1."""
    color = np.asarray(color, dtype=np.float32)
    m = mask[..., None] if image.ndim == 3 else mask
    image += m * (color - image)


def _coordinates(shape):
    """Texel centres (row v, column u) as broadcastable arrays."""
    return np.arange(shape[0], dtype=np.float32)[:, None] + 0.5, np.arange(shape[1], dtype=np.float32)[None, :] + 0.5


def _disc(shape, u, v, radius):
    """Anti-aliased disc; returned with the slices that it lives in."""
    u0, u1 = max(0, int(u - radius - 2)), min(shape[1], int(u + radius + 3))
    v0, v1 = max(0, int(v - radius - 2)), min(shape[0], int(v + radius + 3))
    yy, xx = np.mgrid[v0:v1, u0:u1].astype(np.float32) + 0.5
    return (slice(v0, v1), slice(u0, u1)), np.clip(radius + 0.5 - np.hypot(xx - u, yy - v), 0, 1)


def _scratches(shape, rng, count, length_px, width_px):
    """Mask of thin bent scratches."""
    mask = np.zeros(shape, dtype=np.float32)
    for _ in range(count):
        length = int(length_px * rng.uniform(0.2, 1.0))
        heading = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.normal(0, 0.01, max(length, 2)))
        u = rng.uniform(0, shape[1]) + np.cumsum(np.cos(heading))
        v = rng.uniform(0, shape[0]) + np.cumsum(np.sin(heading))
        for offset in np.arange(0, max(1.0, width_px), 1.0):
            uu, vv = (u + offset).astype(int), v.astype(int)
            inside = (uu >= 0) & (uu < shape[1]) & (vv >= 0) & (vv < shape[0])
            mask[vv[inside], uu[inside]] = rng.uniform(0.4, 1.0)
    return mask


def foil(shape, texels_per_m, rng, color=GOLD, cell_m=0.045):
    """Multi-layer insulation: crumpled facets at three scales, tape seams, stitches, a few stains."""
    slopes = np.zeros((*shape, 2), dtype=np.float32)
    creases = np.zeros(shape, dtype=np.float32)
    for scale, deviation in ((1.0, 0.15), (0.38, 0.12), (0.15, 0.08)):
        sx, sy, crease = noise.facet_slopes(shape, max(3.0, scale * cell_m * texels_per_m), rng, deviation)
        slopes[..., 0] += sx
        slopes[..., 1] += sy
        creases = np.maximum(creases, crease * min(1.0, 0.4 + scale))
    stain = noise.fractal(shape, rng, 2.4, 0.12 * texels_per_m)
    image = _canvas(shape, color)
    image *= (1 + 0.13 * np.clip(stain, -2, 2) - 0.30 * creases)[..., None]
    # Space-worn outer layers are part mirror, part matt: the matt part keeps its pattern as the light moves.
    roughness = np.clip(0.40 + 0.05 * stain + 0.12 * creases, 0.25, 0.7).astype(np.float32)
    metallic = np.full(shape, 0.62, dtype=np.float32)
    _tape(image, roughness, metallic, slopes, texels_per_m, rng)
    return Material(np.clip(image, 0, 1), roughness, metallic, slopes)


def _tape(image, roughness, metallic, slopes, texels_per_m, rng):
    """Bands of kapton tape along two edges and across, with a row of stitches beside each."""
    shape = roughness.shape
    v, u = _coordinates(shape)
    width = 0.018 * texels_per_m
    tint = np.array([0.80, 0.49, 0.14], dtype=np.float32)
    for where in (rng.uniform(0.08, 0.2), rng.uniform(0.42, 0.62), rng.uniform(0.8, 0.93)):
        centre = where * shape[0] + 0.02 * texels_per_m * (u / shape[1] - 0.5) * rng.uniform(-1, 1)
        band = np.clip(width / 2 + 0.5 - np.abs(v - centre), 0, 1).astype(np.float32)
        _paint(image, band, tint * rng.uniform(0.8, 1.1))
        _paint(roughness, band, 0.42)
        _paint(metallic, band, 0.25)
        slopes *= (1 - 0.7 * band)[..., None]
        pitch = 0.011 * texels_per_m
        for n in range(int(shape[1] / pitch)):
            u0 = (n + 0.5) * pitch
            v0 = where * shape[0] + width * 0.85
            area, disc = _disc(shape, u0, v0, 0.0019 * texels_per_m)
            image[area] *= (1 - 0.85 * disc)[..., None]
    for where in rng.uniform(0.1, 0.9, 2):
        line = np.clip(width / 3 + 0.5 - np.abs(u - where * shape[1]), 0, 1) * np.ones_like(v)
        _paint(image, line.astype(np.float32), tint * 0.9)
        _paint(metallic, line.astype(np.float32), 0.3)


def solar_cells(shape, texels_per_m, rng, cell_m=(0.04, 0.08)):
    """Triple-junction cells with cut corners, grid fingers, bus bars, interconnects and coverglass."""
    pitch_u = shape[1] / max(1, round(shape[1] / (cell_m[0] * texels_per_m)))
    pitch_v = shape[0] / max(1, round(shape[0] / (cell_m[1] * texels_per_m)))
    v, u = _coordinates(shape)
    cu, cv = (u % pitch_u) - pitch_u / 2, (v % pitch_v) - pitch_v / 2
    iu, iv = (u // pitch_u).astype(int), (v // pitch_v).astype(int)
    gap = 0.0016 * texels_per_m
    cut = 0.22 * pitch_u
    du, dv = pitch_u / 2 - gap - np.abs(cu), pitch_v / 2 - gap - np.abs(cv)
    inside = np.clip(np.minimum(np.minimum(du, dv), (du + dv - cut) * 0.7) + 0.5, 0, 1).astype(np.float32)
    tone = rng.normal(1, 0.18, (iv.max() + 1, iu.max() + 1)).astype(np.float32)
    hue = rng.normal(0, 0.025, (iv.max() + 1, iu.max() + 1)).astype(np.float32)
    image = _canvas(shape, (0.66, 0.62, 0.54))
    grain = noise.fractal(shape, rng, 1.2, 0.02 * texels_per_m)
    image *= (1 + 0.12 * grain)[..., None]
    cell = np.stack([0.17 + hue[iv, iu], 0.19 + 0 * hue[iv, iu], 0.34 - hue[iv, iu]], axis=-1)
    cell = cell * tone[iv, iu][..., None] * (1 + 0.05 * grain)[..., None]
    image += inside[..., None] * (cell - image)
    finger = 0.0022 * texels_per_m
    lines = np.clip(1.0 - np.abs(((v % finger) / finger - 0.5) * finger) / max(0.5, 0.12 * finger), 0, 1) * 0.35
    bars = np.clip(0.0009 * texels_per_m + 0.5 - np.abs(np.abs(cu) - 0.26 * pitch_u), 0, 1)
    metal = (np.maximum(lines * np.ones_like(u), bars * np.ones_like(v)) * inside).astype(np.float32)
    _paint(image, metal * 0.8, (0.72, 0.73, 0.75))
    tabs = np.clip(0.0022 * texels_per_m + 0.5 - np.abs(np.abs(cu) - 0.26 * pitch_u), 0, 1)
    tabs = (tabs * np.clip(1 - dv / (2 * gap), 0, 1)).astype(np.float32)
    _paint(image, tabs, (0.82, 0.82, 0.84))
    roughness = np.where(inside > 0.5, 0.16, 0.6).astype(np.float32)
    metallic = (0.35 * np.maximum(metal, tabs)).astype(np.float32)
    _wear_of_cells(image, inside, iu, iv, rng)
    # Each coverglass is glued at its own small tilt: this is what makes an array glitter cell by cell.
    tilt = rng.normal(0, 0.012, (iv.max() + 1, iu.max() + 1, 2)).astype(np.float32)
    return Material(np.clip(image, 0, 1), roughness, metallic, tilt[iv, iu] * inside[..., None])


def _wear_of_cells(image, inside, iu, iv, rng):
    """Some cells cracked, one discoloured, impact pits: the only marks that tell repeating cells apart."""
    shape = inside.shape
    cracks = _scratches(shape, rng, 6, 0.12 * shape[0], 2.0) * inside
    _paint(image, cracks, (0.6, 0.6, 0.62))
    bad_v, bad_u = rng.integers(0, iv.max() + 1), rng.integers(0, iu.max() + 1)
    image *= np.where((iu == bad_u) & (iv == bad_v), 0.55, 1.0)[..., None].astype(np.float32)
    for _ in range(14):
        area, disc = _disc(
            shape,
            rng.uniform(0, shape[1]),
            rng.uniform(0, shape[0]),
            rng.uniform(0.5, 1.0) * max(1.2, 0.006 * max(shape)),
        )
        image[area] += disc[..., None] * (np.float32(rng.choice([0.75, 0.03])) - image[area])


def plate(shape, texels_per_m, rng, color=(0.80, 0.80, 0.78), text=(), metallic=0.0, panels=True, wear=1.0, decals=True):
    """Painted or bare plate: panel gaps, screws, lettering, stripes, fiducial-like decals, dirt and scratches."""
    image = _canvas(shape, color)
    dirt = noise.fractal(shape, rng, 2.2, 0.25 * texels_per_m)
    speck = noise.fractal(shape, rng, 0.8, 0.01 * texels_per_m)
    image *= (1 + wear * (0.055 * dirt + 0.035 * speck))[..., None]
    height = np.zeros(shape, dtype=np.float32)
    roughness = np.clip(0.48 + 0.06 * dirt, 0.2, 0.9).astype(np.float32)
    metal = np.full(shape, metallic, dtype=np.float32)
    if panels:
        _gaps_and_screws(image, height, metal, texels_per_m, rng)
    if decals:
        _decals(image, texels_per_m, rng, text)
    scratch = _scratches(shape, rng, int(26 * wear), 0.16 * texels_per_m, 0.0009 * texels_per_m)
    _paint(image, 0.8 * scratch, (0.93, 0.93, 0.95))
    dark = _scratches(shape, rng, int(16 * wear), 0.10 * texels_per_m, 0.0012 * texels_per_m)
    _paint(image, 0.7 * dark, (0.2, 0.19, 0.18))
    for _ in range(int(28 * wear)):
        radius = texels_per_m * rng.uniform(0.0008, 0.005)
        area, disc = _disc(shape, rng.uniform(0, shape[1]), rng.uniform(0, shape[0]), radius)
        image[area] *= (1 - rng.uniform(0.3, 0.85) * disc)[..., None]
    slopes = slopes_from_height(height) + 0.02 * np.stack([dirt, speck], axis=-1)
    return Material(np.clip(image, 0, 1), roughness, metal, slopes.astype(np.float32))


def _gaps_and_screws(image, height, metal, texels_per_m, rng):
    """A border, one or two cover plates, and screws along each of them."""
    shape = height.shape
    v, u = _coordinates(shape)
    frames = [(0.03, 0.03, 0.97, 0.97)]
    u0, v0 = rng.uniform(0.1, 0.3), rng.uniform(0.1, 0.4)
    frames.append((u0, v0, u0 + rng.uniform(0.3, 0.55), v0 + rng.uniform(0.18, 0.35)))
    frames.append((rng.uniform(0.1, 0.4), rng.uniform(0.6, 0.7), rng.uniform(0.6, 0.9), rng.uniform(0.8, 0.92)))
    gap = 0.0016 * texels_per_m
    for a, b, c, d in frames:
        a, b, c, d = a * shape[1], b * shape[0], c * shape[1], d * shape[0]
        outside = np.maximum(np.maximum(a - u, u - c), np.maximum(b - v, v - d))
        line = np.clip(gap + 0.5 - np.abs(outside), 0, 1).astype(np.float32)
        image *= (1 - 0.75 * line)[..., None]
        height -= 2.0 * line
        tone = np.float32(rng.uniform(0.88, 1.1))
        image *= np.where(outside < 0, tone, 1.0)[..., None].astype(np.float32)
        inset, pitch = 0.012 * texels_per_m, 0.055 * texels_per_m
        for p in _around(a + inset, b + inset, c - inset, d - inset, pitch):
            _screw(image, height, metal, p, 0.0048 * texels_per_m, rng)


def _around(u0, v0, u1, v1, pitch):
    """Points along a rectangle at about the given pitch."""
    nu, nv = max(1, round((u1 - u0) / pitch)), max(1, round((v1 - v0) / pitch))
    us, vs = np.linspace(u0, u1, nu + 1), np.linspace(v0, v1, nv + 1)
    return [(a, b) for a in us for b in (v0, v1)] + [(a, b) for b in vs[1:-1] for a in (u0, u1)]


def _screw(image, height, metal, point, radius, rng):
    area, disc = _disc(height.shape, point[0], point[1], radius * 1.35)
    image[area] *= (1 - 0.7 * disc)[..., None]
    area, disc = _disc(height.shape, point[0], point[1], radius)
    image[area] += disc[..., None] * (np.float32(0.66) - image[area])
    metal[area] = np.maximum(metal[area], 0.8 * disc)
    height[area] += 1.2 * disc
    area, disc = _disc(height.shape, point[0], point[1], radius * 0.42)
    image[area] *= (1 - 0.85 * disc)[..., None]


def _decals(image, texels_per_m, rng, text):
    """Lettering, a hazard stripe and a small checker: marks with strong corners."""
    shape = image.shape[:2]
    for n, line in enumerate(text):
        size = max(1, int(round(0.0065 * texels_per_m)))
        mask = glyphs.text_mask(line, size)
        if mask.shape[1] > 0.9 * shape[1]:
            mask = glyphs.text_mask(line, max(1, int(0.9 * shape[1] / (6 * len(line)))))
        _stamp(image, mask, rng.uniform(0.05, 0.95), 0.5 + 0.13 * n, (0.07, 0.08, 0.16))
    block = max(2, int(0.012 * texels_per_m))
    checker = np.kron(rng.integers(0, 2, (4, 4)), np.ones((block, block))).astype(np.float32)
    _stamp(image, np.ones_like(checker), 0.12, 0.15, (0.9, 0.9, 0.9))
    _stamp(image, checker, 0.12, 0.15, (0.05, 0.05, 0.05))
    yy, xx = np.mgrid[0 : 2 * block, 0 : 14 * block]
    stripe = (((xx + yy) // block) % 2).astype(np.float32)
    _stamp(image, np.ones_like(stripe), 0.9, 0.06, (0.85, 0.68, 0.1))
    _stamp(image, stripe, 0.9, 0.06, (0.06, 0.06, 0.06))


def _stamp(image, mask, fraction_u, fraction_v, color):
    """Lays a mask over the image, placed by the fraction of the free room left and below it."""
    h, w = image.shape[:2]
    mask = mask[:h, :w]
    v0, u0 = int(fraction_v * (h - mask.shape[0])), int(fraction_u * (w - mask.shape[1]))
    _paint(image[v0 : v0 + mask.shape[0], u0 : u0 + mask.shape[1]], mask, color)


def weave(shape, texels_per_m, rng, color=(0.13, 0.13, 0.14)):
    """Carbon-fibre face sheet with a harness taped over it: the back of a panel."""
    v, u = _coordinates(shape)
    tow = max(3.0, 0.004 * texels_per_m)
    pattern = ((np.floor(u / tow) + np.floor(v / tow)) % 2).astype(np.float32)
    image = _canvas(shape, color) * (0.8 + 0.4 * pattern)[..., None]
    dirt = noise.fractal(shape, rng, 2.0, 0.2 * texels_per_m)
    image *= (1 + 0.12 * dirt)[..., None]
    height = 0.15 * pattern
    metal = np.zeros(shape, dtype=np.float32)
    for k in range(4):
        centre = (0.15 + 0.22 * k) * shape[1] + 0.012 * texels_per_m * np.sin(v / (0.07 * texels_per_m) + k)
        wire = np.clip(0.0032 * texels_per_m - np.abs(u - centre) + 0.5, 0, 1).astype(np.float32)
        _paint(image, wire, [(0.75, 0.72, 0.66), (0.55, 0.16, 0.1), (0.8, 0.8, 0.8), (0.7, 0.45, 0.12)][k])
        height += 2.5 * wire
        for where in rng.uniform(0.03, 0.97, 7):
            _stamp(
                image,
                np.ones((int(0.011 * texels_per_m), int(0.035 * texels_per_m)), np.float32),
                0.1 + 0.22 * k,
                where,
                np.array([0.72, 0.47, 0.16]) * rng.uniform(0.7, 1.1),
            )
    for p in _around(0.03 * shape[1], 0.015 * shape[0], 0.97 * shape[1], 0.985 * shape[0], 0.06 * texels_per_m):
        _screw(image, height, metal, p, 0.004 * texels_per_m, rng)
    return Material(np.clip(image, 0, 1), 0.42, metal, slopes_from_height(height))
