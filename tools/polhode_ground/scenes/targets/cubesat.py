"""A small satellite: a box with two deployed panels, foil on two sides, body cells, instruments, antennas.

Frame G: origin at the box's centre, x out of the instrument side, z bottom to top, y along the panels' hinges'
normal. size_m is the height over all, along z.
"""

import numpy as np

from .. import mesh, noise, surfaces
from ..materials import Material

# Fractions of size_m.
HALF_WIDTH = 0.18
HALF_HEIGHT = 0.43
PANEL_GAP = 0.025
PANEL_WIDTH = 0.29
PANEL_THICKNESS = 0.012


def build(size_m, detail_seed, texture_px, panel_length_m=None):
    """Parts, materials and known lengths. Returns (parts, {name: Material}, [known length dict in G])."""
    s = size_m
    panel_length_m = panel_length_m or 0.80 * s
    density = texture_px / s
    parts = _body(s, detail_seed) + _instruments(s) + _rods_and_thrusters(s) + _panels(s, panel_length_m)
    materials = _materials(s, detail_seed, density, panel_length_m)
    y = (HALF_WIDTH + PANEL_GAP) * s
    outer = y + PANEL_WIDTH * s
    z = panel_length_m / 2
    known = [
        {
            "name": "panel_long_edge",
            "length_m": panel_length_m,
            "normal_G": [1.0, 0.0, 0.0],
            "a_G_m": [PANEL_THICKNESS * s / 2, outer, -z],
            "b_G_m": [PANEL_THICKNESS * s / 2, outer, z],
        },
        {
            "name": "panel_short_edge",
            "length_m": PANEL_WIDTH * s,
            "normal_G": [1.0, 0.0, 0.0],
            "a_G_m": [PANEL_THICKNESS * s / 2, y, z],
            "b_G_m": [PANEL_THICKNESS * s / 2, outer, z],
        },
    ]
    return parts, materials, known


def _body(s, seed):
    """Six sides, two of them in loose foil, over a bevelled box that shows along the edges."""
    w, h = HALF_WIDTH * s, HALF_HEIGHT * s
    lift, inset = 0.003 * s, 0.010 * s
    a, b = w - inset, h - inset
    side = [
        ("x_plus", [w + lift, -a, -b], [0, 2 * a, 0], [0, 0, 2 * b], "plate_x", False),
        ("x_minus", [-w - lift, a, -b], [0, -2 * a, 0], [0, 0, 2 * b], "foil_gold", True),
        ("y_plus", [a, w + lift, -b], [-2 * a, 0, 0], [0, 0, 2 * b], "cells_body", False),
        ("y_minus", [-a, -w - lift, -b], [2 * a, 0, 0], [0, 0, 2 * b], "foil_silver", True),
        ("z_plus", [-a, -a, h + lift], [2 * a, 0, 0], [0, 2 * a, 0], "plate_z", False),
        ("z_minus", [-a, a, -h - lift], [2 * a, 0, 0], [0, -2 * a, 0], "plate_base", False),
    ]
    parts = [mesh.box("body_frame", [-w, -w, -h], [w, w, h], "rail", 0.008 * s)]
    for n, (name, origin, u, v, material, crumpled) in enumerate(side):
        counts, height = (1, 1), None
        if crumpled:
            counts = (36, 84)
            height = _billow(counts, noise.generator(seed, 50 + n), 0.007 * s)
        parts.append(mesh.grid_patch(name, origin, u, v, counts, material, height))
    return parts


def _billow(counts, rng, amplitude_m):
    """Heights (nv + 1, nu + 1) of a loose blanket, zero along its taped edges."""
    shape = (counts[1] + 1, counts[0] + 1)
    wave = noise.fractal(shape, rng, 2.6, 18)
    v, u = np.meshgrid(np.linspace(0, 1, shape[0]), np.linspace(0, 1, shape[1]), indexing="ij")
    edge = np.clip(8 * np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v)), 0, 1)
    return amplitude_m * (0.5 + 0.5 * np.clip(wave, -1.5, 2)) * edge


def _instruments(s):
    """What stands out of the box: telescope, star tracker, boxes, patch antennas, launch ring."""
    w, h = HALF_WIDTH * s, HALF_HEIGHT * s
    return [
        mesh.cylinder("telescope", [w, 0.02 * s, 0.20 * s], [w + 0.055 * s, 0.02 * s, 0.20 * s], 0.085 * s, "black", 48),
        mesh.lathe(
            "telescope_rim",
            np.array([(0.05, 0.072), (0.062, 0.072), (0.062, 0.088), (0.0, 0.088)]) * s,
            [w, 0.02 * s, 0.20 * s],
            [1, 0, 0],
            "metal",
            48,
            False,
        ),
        mesh.cylinder(
            "telescope_glass",
            [w + 0.05 * s, 0.02 * s, 0.20 * s],
            [w + 0.0565 * s, 0.02 * s, 0.20 * s],
            0.070 * s,
            "glass",
            48,
        ),
        mesh.box("electronics", [w, -0.13 * s, -0.28 * s], [w + 0.035 * s, -0.02 * s, -0.13 * s], "box_white", 0.004 * s),
        mesh.box(
            "connector",
            [w + 0.035 * s, -0.11 * s, -0.22 * s],
            [w + 0.045 * s, -0.05 * s, -0.19 * s],
            "metal",
            0.002 * s,
        ),
        mesh.box("patch_antenna", [w, 0.04 * s, -0.33 * s], [w + 0.012 * s, 0.14 * s, -0.23 * s], "ceramic", 0.003 * s),
        mesh.cylinder("star_tracker", [-0.06 * s, 0.05 * s, h], [-0.085 * s, 0.08 * s, h + 0.068 * s], 0.042 * s, "black", 32),
        mesh.box("gps_patch", [0.04 * s, -0.12 * s, h], [0.12 * s, -0.04 * s, h + 0.018 * s], "ceramic", 0.003 * s),
        mesh.box("valve_box", [0.05 * s, 0.05 * s, h], [0.13 * s, 0.12 * s, h + 0.045 * s], "box_white", 0.004 * s),
        mesh.lathe(
            "launch_ring",
            np.array([(0, 0.135), (0.03, 0.135), (0.03, 0.15), (0.05, 0.15), (0.05, 0.115), (0, 0.115)]) * s,
            [0, 0, -h],
            [0, 0, -1],
            "metal",
            64,
            False,
        ),
    ]


def _rods_and_thrusters(s):
    """Thrusters around the base, two rod antennas, a cable between the boxes."""
    w, h = HALF_WIDTH * s, HALF_HEIGHT * s
    parts = []
    for k, (x, y) in enumerate(((0.14, 0.14), (-0.14, 0.14), (-0.14, -0.14), (0.14, -0.14))):
        profile = np.array([(0, 0.010), (0.012, 0.012), (0.030, 0.020), (0.030, 0.018), (0.004, 0.006)]) * s
        parts.append(mesh.lathe(f"thruster_{k}", profile, [x * s, y * s, -h], [0, 0, -1], "metal", 24))
        tip = np.array([x * 2.1 * s, y * 0.9 * s, h + 0.068 * s])
        if k in (0, 2):
            parts.append(mesh.cylinder(f"antenna_{k}", [x * s, y * s, h], tip, 0.0035 * s, "metal", 10))
    path = [[w + 0.006 * s, -0.06 * s + 0.015 * s * np.sin(t * 9), (-0.13 + 0.26 * t) * s] for t in np.linspace(0, 1, 24)]
    parts.append(mesh.tube("cable", path, 0.005 * s, "cable"))
    return parts


def _panels(s, length_m):
    """Two panels on hinges: cells towards +x, carbon with harness towards -x, a thin frame around."""
    t, z = PANEL_THICKNESS * s / 2, length_m / 2
    parts = []
    for sign, tag in ((1, "a"), (-1, "b")):
        near = (HALF_WIDTH + PANEL_GAP) * s
        far = near + PANEL_WIDTH * s
        y0, y1 = sorted((sign * near, sign * far))
        parts.append(mesh.box(f"panel_core_{tag}", [-t, y0, -z], [t, y1, z], "rail"))
        m, lift = 0.006 * s, 0.0012 * s
        parts.append(
            mesh.grid_patch(
                f"panel_front_{tag}",
                [t + lift, y0 + m, -z + m],
                [0, y1 - y0 - 2 * m, 0],
                [0, 0, 2 * z - 2 * m],
                (1, 1),
                f"cells_{tag}",
            )
        )
        parts.append(
            mesh.grid_patch(
                f"panel_back_{tag}",
                [-t - lift, y1 - m, -z + m],
                [0, y0 - y1 + 2 * m, 0],
                [0, 0, 2 * z - 2 * m],
                (1, 1),
                f"back_{tag}",
            )
        )
        for zh in (-0.6 * z, 0.0, 0.6 * z):
            low = [-0.012 * s, min(sign * HALF_WIDTH * s, sign * near), zh - 0.02 * s]
            high = [0.012 * s, max(sign * HALF_WIDTH * s, sign * near), zh + 0.02 * s]
            parts.append(mesh.box(f"hinge_{tag}", low, high, "metal", 0.003 * s))
    return parts


def _materials(s, seed, density, panel_length_m):
    """Materials by name; each texture has its own generator, so that one does not shift the others."""

    def texture(width_m, height_m):
        return max(16, int(height_m * density)), max(16, int(width_m * density))

    side = texture(0.34 * s, 0.84 * s)
    end = texture(0.34 * s, 0.34 * s)
    panel = texture(PANEL_WIDTH * s, panel_length_m)
    # Detail is sized in fractions of the satellite, so that a small one is not covered by a single crease.
    unit = density * s
    rng = [noise.generator(seed, n) for n in range(12)]
    return {
        "plate_x": surfaces.plate(side, unit, rng[0], (0.72, 0.72, 0.69), ("POLHODE-1", "TCS 04", "RF HAZARD")),
        "foil_gold": surfaces.foil(side, unit, rng[1], surfaces.GOLD),
        "cells_body": surfaces.solar_cells(side, unit, rng[2], (0.068, 0.105)),
        "foil_silver": surfaces.foil(side, unit, rng[3], surfaces.SILVER),
        "plate_z": surfaces.plate(end, unit, rng[4], (0.62, 0.60, 0.55), ("PX-2", "LIFT"), metallic=0.55),
        "plate_base": surfaces.plate(end, unit, rng[5], (0.58, 0.55, 0.47), ("SEP RING 3", "NO STEP"), metallic=0.3),
        "cells_a": surfaces.solar_cells(panel, unit, rng[6], (0.058, 0.098)),
        "cells_b": surfaces.solar_cells(panel, unit, rng[7], (0.058, 0.098)),
        "back_a": surfaces.weave(panel, unit, rng[8]),
        "back_b": surfaces.weave(panel, unit, rng[9]),
        "box_white": surfaces.plate((256, 256), unit, rng[10], (0.84, 0.84, 0.82), ("A2",), panels=False),
        "rail": Material((0.66, 0.67, 0.69), 0.38, 0.75),
        "metal": Material((0.72, 0.72, 0.73), 0.30, 0.9),
        "black": Material((0.09, 0.09, 0.095), 0.55),
        "ceramic": Material((0.72, 0.66, 0.52), 0.4),
        "glass": Material((0.02, 0.025, 0.05), 0.06, 0.0, clearcoat=1.0),
        "cable": Material((0.74, 0.68, 0.60), 0.5),
    }
