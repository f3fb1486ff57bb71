"""A spent upper stage: painted tank with weld seams and stripes, adapter cone, engine with its nozzle.

Frame G: z along the stage, nozzle towards -z, origin at the middle of the length over all. size_m is that length.
"""

import numpy as np

from .. import glyphs, mesh, noise, surfaces
from ..materials import Material, slopes_from_height

RADIUS = 0.135
TANK_LOW, TANK_HIGH = -0.22, 0.36


def build(size_m, detail_seed, texture_px):
    """Parts, materials and known lengths in G."""
    s = size_m
    parts = _hull(s) + _engine(s) + _fittings(s)
    known = [
        {
            "name": "tank_diameter",
            "length_m": 2 * RADIUS * s,
            "normal_G": [1.0, 0.0, 0.0],
            "a_G_m": [0.0, -RADIUS * s, TANK_HIGH * s],
            "b_G_m": [0.0, RADIUS * s, TANK_HIGH * s],
        }
    ]
    return parts, _materials(s, detail_seed, texture_px), known


def _lathe(name, profile, s, material, segments=96, smooth=True):
    return mesh.lathe(name, np.asarray(profile) * s, [0, 0, 0], [0, 0, 1], material, segments, smooth)


def _dome(z0, z1, radius, count=14):
    """Elliptic dome profile from the rim at z0 to the pole at z1."""
    a = np.linspace(0, np.pi / 2, count)
    return np.stack([z0 + (z1 - z0) * np.sin(a), radius * np.cos(a)], axis=1)


def _hull(s):
    """Tank, domes, adapter cone and rings."""
    parts = [
        _lathe("tank", [(TANK_LOW, RADIUS), (TANK_HIGH, RADIUS)], s, "tank", 128),
        _lathe("aft_dome", _dome(TANK_LOW, TANK_LOW - 0.075, RADIUS)[::-1], s, "dome"),
        _lathe("adapter", [(TANK_HIGH, RADIUS), (0.475, 0.075)], s, "adapter"),
        _lathe("adapter_inside", [(0.475, 0.073), (TANK_HIGH + 0.01, 0.125)], s, "inside"),
        _lathe("forward_dome", _dome(TANK_HIGH, TANK_HIGH + 0.05, 0.13), s, "dome"),
    ]
    for name, z, r, thick, height in (
        ("ring_aft", TANK_LOW, RADIUS, 0.004, 0.012),
        ("ring_forward", TANK_HIGH, RADIUS, 0.004, 0.010),
        ("ring_payload", 0.475, 0.075, 0.006, 0.024),
        ("ring_mid", 0.09, RADIUS, 0.002, 0.008),
    ):
        profile = [
            (z - height / 2, r - 0.002),
            (z - height / 2, r + thick),
            (z + height / 2, r + thick),
            (z + height / 2, r - 0.002),
        ]
        parts.append(_lathe(name, profile, s, "metal", 96, False))
    return parts


def _engine(s):
    """Thrust cone, chamber and bell, turbine pipes, pressure spheres."""
    t = np.linspace(0, 1, 16)
    bell = np.stack([-0.345 - 0.155 * t, 0.020 + 0.070 * t**0.62], axis=1)
    inner = bell - [0, 0.002]
    profile = np.concatenate([bell[::-1], inner[1:]])
    parts = [
        _lathe("nozzle", profile, s, "nozzle", 72),
        _lathe(
            "chamber",
            [(-0.345, 0.020), (-0.33, 0.022), (-0.315, 0.034), (-0.285, 0.034), (-0.275, 0.02)],
            s,
            "engine",
            48,
        ),
        _lathe("thrust_cone", [(-0.285, 0.03), (TANK_LOW - 0.055, 0.075)], s, "engine", 12, False),
        _lathe("bell_ring", [(-0.43, 0.069), (-0.43, 0.0725), (-0.424, 0.0725), (-0.424, 0.067)], s, "metal", 72, False),
        mesh.cylinder("pump", [0.05 * s, 0.02 * s, -0.27 * s], [0.05 * s, 0.02 * s, -0.335 * s], 0.018 * s, "engine", 20),
    ]
    for k in range(4):
        angle = np.pi / 4 + k * np.pi / 2
        centre = np.array([0.092 * np.cos(angle), 0.092 * np.sin(angle), -0.262]) * s
        parts.append(mesh.sphere(f"bottle_{k}", centre, 0.033 * s, "bottle", 28, 14))
        path = np.array(
            [
                [0.092 * np.cos(angle), 0.092 * np.sin(angle), -0.285],
                [0.07 * np.cos(angle), 0.07 * np.sin(angle), -0.31],
                [0.034 * np.cos(angle), 0.034 * np.sin(angle), -0.315],
            ]
        )
        dense = np.stack([np.interp(np.linspace(0, 2, 16), [0, 1, 2], path[:, i]) for i in range(3)], axis=1)
        parts.append(mesh.tube(f"pipe_{k}", dense * s, 0.005 * s, "metal"))
    return parts


def _fittings(s):
    """Raceway, feed line, control thrusters, an antenna: the few things that break the symmetry."""
    r = RADIUS * s
    parts = [
        mesh.box(
            "raceway",
            [r - 0.004 * s, -0.010 * s, TANK_LOW * s],
            [r + 0.012 * s, 0.010 * s, 0.33 * s],
            "raceway",
            0.003 * s,
        ),
        mesh.cylinder(
            "feed_line",
            [-0.5 * r, -0.875 * r - 0.006 * s, -0.2 * s],
            [-0.5 * r, -0.875 * r - 0.006 * s, 0.10 * s],
            0.008 * s,
            "raceway",
            16,
        ),
        mesh.box("avionics", [-0.02 * s, r - 0.004 * s, 0.27 * s], [0.03 * s, r + 0.014 * s, 0.33 * s], "raceway", 0.003 * s),
        mesh.box("antenna", [-r - 0.01 * s, 0.03 * s, 0.20 * s], [-r + 0.01 * s, 0.045 * s, 0.25 * s], "dome", 0.002 * s),
    ]
    for k, angle in enumerate((np.pi * 0.75, -np.pi * 0.25)):
        axis = np.array([np.cos(angle), np.sin(angle), 0])
        base = axis * r + np.array([0, 0, -0.17 * s])
        parts.append(mesh.box(f"pod_{k}", base - 0.018 * s, base + 0.018 * s, "raceway", 0.005 * s))
        bell = np.array([(0.0, 0.006), (0.008, 0.007), (0.022, 0.013), (0.022, 0.011), (0.004, 0.004)]) * s
        parts.append(mesh.lathe(f"jet_{k}", bell, base - [0, 0, 0.018 * s], [0, 0, -1], "metal", 20))
    return parts


def _tank_skin(s, seed, texture_px):
    """White paint, ring and long welds, roll-pattern stripes, lettering, soot towards the engine."""
    rng = noise.generator(seed, 40)
    height, width = int((TANK_HIGH - TANK_LOW) * texture_px), int(2 * np.pi * RADIUS * texture_px)
    shape, unit = (height, width), float(texture_px)
    dirt = noise.fractal(shape, rng, 2.4, 0.2 * unit)
    color = np.ones((*shape, 3), dtype=np.float32) * np.array([0.83, 0.83, 0.81], dtype=np.float32)
    color *= (1 + 0.03 * dirt + 0.008 * noise.fractal(shape, rng, 0.6, 0.01 * unit))[..., None]
    relief = np.zeros(shape, dtype=np.float32)
    v = (np.arange(height, dtype=np.float32) + 0.5)[:, None] / unit
    u = (np.arange(width, dtype=np.float32) + 0.5)[None, :] / width
    for z in (0.06, 0.185, 0.31, 0.425, 0.52):
        _weld(color, relief, np.abs(v - z) * unit * np.ones_like(u), rng)
    for k, u0 in enumerate((0.11, 0.36, 0.61, 0.86)):
        low, high = ((0.06, 0.31), (0.31, 0.52), (0.185, 0.425), (0.06, 0.185))[k]
        inside = ((v > low) & (v < high)).astype(np.float32)
        _weld(color, relief, np.where(inside > 0, np.abs(u - u0) * width, 1e3).astype(np.float32), rng)
    black = np.array([0.07, 0.07, 0.08], dtype=np.float32)
    band = ((v > 0.445) & (v < 0.468)) * np.ones_like(u)
    roll = (((u * 4).astype(int) % 2) * ((v > 0.485) & (v < 0.555))).astype(np.float32)
    for mask in (band, roll, ((np.abs(u - 0.735) < 0.012) & (v > 0.10) & (v < 0.40)).astype(np.float32)):
        color += mask[..., None].astype(np.float32) * (black - color)
    for u0, text in ((0.22, "PX-U2"), (0.72, "STAGE 2")):
        _vertical_text(color, text, u0, 0.17, unit)
    soot = surfaces_soot(v, dirt)
    color *= (1 - soot)[..., None]
    scars = noise.generator(seed, 41)
    for _ in range(46):
        y, x, r = scars.uniform(0, height), scars.uniform(0, width), scars.uniform(0.0012, 0.006) * unit
        yy, xx = np.ogrid[max(0, int(y - r)) : min(height, int(y + r) + 1), max(0, int(x - r)) : min(width, int(x + r) + 1)]
        spot = (np.hypot(yy - y, xx - x) < r)[..., None]
        area = (
            slice(max(0, int(y - r)), min(height, int(y + r) + 1)),
            slice(max(0, int(x - r)), min(width, int(x + r) + 1)),
        )
        color[area] *= np.where(spot, np.float32(scars.uniform(0.35, 0.85)), 1)
    return Material(np.clip(color, 0, 1), 0.38, 0.0, slopes_from_height(relief))


def _weld(color, relief, distance_px, rng):
    """A bead with a heat-tinted zone, given the distance to its line in texels."""
    del rng
    bead = np.exp(-((distance_px / 1.6) ** 2))
    zone = np.exp(-((distance_px / 7.0) ** 2))
    color *= (1 - 0.10 * zone - 0.22 * bead)[..., None]
    relief += 1.6 * bead


def surfaces_soot(v, dirt):
    """Darkening (H, W) in [0, 0.6] that fades with the height v above the engine end, in lengths."""
    return np.clip(0.42 * np.exp(-v / 0.05) * (1 + 0.4 * dirt), 0, 0.6).astype(np.float32)


def _vertical_text(color, text, u0, v0, unit):
    """Lettering that reads upward along the stage."""
    mask = np.rot90(glyphs.text_mask(text, max(1, int(0.006 * unit))))
    row, column = int(v0 * unit), int(u0 * color.shape[1])
    area = color[row : row + mask.shape[0], column : column + mask.shape[1]]
    mask = mask[: area.shape[0], : area.shape[1]]
    area += mask[..., None] * (np.array([0.10, 0.12, 0.35], dtype=np.float32) - area)


def _materials(s, seed, texture_px):
    rng = [noise.generator(seed, 42 + n) for n in range(6)]
    small = (max(64, texture_px // 4), max(64, texture_px // 2))
    return {
        "tank": _tank_skin(s, seed, texture_px),
        "dome": surfaces.plate(small, texture_px, rng[0], (0.66, 0.63, 0.56), (), 0.3, panels=False, decals=False),
        "adapter": surfaces.weave(small, texture_px, rng[1], (0.20, 0.20, 0.21)),
        "inside": Material((0.25, 0.24, 0.22), 0.7),
        "engine": surfaces.plate(small, texture_px, rng[2], (0.46, 0.44, 0.42), (), 0.6, panels=False, decals=False, wear=2),
        "nozzle": surfaces.plate(small, texture_px, rng[3], (0.30, 0.27, 0.26), (), 0.55, panels=False, decals=False, wear=2),
        "raceway": surfaces.plate(small, texture_px, rng[4], (0.74, 0.74, 0.72), (), panels=False, decals=False),
        "bottle": surfaces.foil(small, texture_px, rng[5], surfaces.GOLD, 0.03),
        "metal": Material((0.70, 0.70, 0.71), 0.32, 0.9),
    }
