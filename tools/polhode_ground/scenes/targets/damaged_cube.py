"""A cube-shaped satellite with one side torn off: jagged rims, bent skins, the inside in view.

Frame G: origin at the centre of the undamaged cube, axes along its edges; the side towards +x is gone.
size_m is the edge of the undamaged cube.
"""

import numpy as np

from .. import mesh, noise, surfaces
from ..materials import Material, slopes_from_height

CELLS = 88
SKIN = 0.022


class Tear:
    """The cut: a height field x = cut(y, z) in units of the edge, with jags of several sizes."""

    def __init__(self, rng):
        self.waves = []
        for frequency, amplitude in ((3.1, 0.050), (7.3, 0.030), (17.0, 0.014), (39.0, 0.005)):
            for _ in range(3):
                heading = rng.uniform(0, 2 * np.pi)
                self.waves.append((frequency * np.cos(heading), frequency * np.sin(heading), rng.uniform(0, 1), amplitude))
        self.lean = rng.uniform(-0.16, 0.16, 2)

    def cut(self, y, z):
        out = 0.22 + self.lean[0] * y + self.lean[1] * z - 0.35 * np.clip(y + z - 0.45, 0, None)
        for fy, fz, phase, amplitude in self.waves:
            # Triangle waves: torn sheet ends in points, not in swells.
            t = (fy * y + fz * z + phase) % 1.0
            out = out + amplitude * (4 * np.abs(t - 0.5) - 1)
        return out


def build(size_m, detail_seed, texture_px):
    """Parts, materials and known lengths in G."""
    tear = Tear(noise.generator(detail_seed, 90))
    parts = []
    for name, axis, sign in (
        ("x_plus", 0, 1),
        ("x_minus", 0, -1),
        ("y_plus", 1, 1),
        ("y_minus", 1, -1),
        ("z_plus", 2, 1),
        ("z_minus", 2, -1),
    ):
        parts += _wall(name, axis, sign, tear, size_m, noise.generator(detail_seed, 91, axis, sign + 1))
    parts += _inside(size_m, noise.generator(detail_seed, 92)) + _outside(size_m)
    h = size_m / 2
    known = [
        {
            "name": "cube_edge",
            "length_m": size_m,
            "normal_G": [-1.0, 0.0, 0.0],
            "a_G_m": [-h, -h, -h],
            "b_G_m": [-h, -h, h],
        },
        {
            "name": "cube_edge_2",
            "length_m": size_m,
            "normal_G": [-1.0, 0.0, 0.0],
            "a_G_m": [-h, h, -h],
            "b_G_m": [-h, h, h],
        },
    ]
    return parts, _materials(size_m, detail_seed, texture_px), known


def _wall(name, axis, sign, tear, size_m, rng):
    """One sandwich panel: outer skin, inner skin and the torn rim between them. Coordinates in edges until the end."""
    normal = np.zeros(3)
    normal[axis] = sign
    u_axis = np.zeros(3)
    u_axis[1 if axis == 0 else 0] = 1.0
    v_axis = np.cross(normal, u_axis)
    line = np.linspace(-0.5, 0.5, CELLS + 1)
    s, t = np.meshgrid(line, line)
    p = 0.5 * normal + s[..., None] * u_axis + t[..., None] * v_axis
    uv = np.stack([s + 0.5, t + 0.5], axis=-1).reshape(-1, 2)
    p = p.reshape(-1, 3)
    room = tear.cut(p[:, 1], p[:, 2]) - p[:, 0]
    faces = mesh.grid_faces(CELLS + 1, CELLS + 1)
    faces = faces[room[faces].mean(axis=1) > 0]
    if len(faces) == 0:
        return []
    if axis != 0:
        over = room < 0
        p[over, 0] += room[over]
        room = np.maximum(room, 0)
    curl = np.clip(1 - room / 0.16, 0, 1) ** 2
    wave = noise.fractal((CELLS + 1, CELLS + 1), rng, 2.8, 30).ravel()
    outer = p + (curl * (0.025 + 0.035 * wave))[:, None] * normal
    inner = outer - SKIN * normal
    parts = [
        mesh.Part(f"{name}_skin", outer * size_m, faces, uv[faces], name),
        mesh.Part(f"{name}_inner", inner * size_m, faces[:, ::-1], uv[faces[:, ::-1]], "inner"),
    ]
    rim = _rim(faces)
    quads = np.stack([rim[:, 0], rim[:, 0] + len(outer), rim[:, 1] + len(outer), rim[:, 1]], axis=1)
    both = np.concatenate([outer, inner]) * size_m
    along = np.cumsum(np.linalg.norm(outer[rim[:, 1]] - outer[rim[:, 0]], axis=1))
    zero = 0 * along
    rim_uv = np.stack(
        [
            np.stack([along, zero], -1),
            np.stack([along, zero + SKIN], -1),
            np.stack([along + 0.01, zero + SKIN], -1),
            np.stack([along + 0.01, zero], -1),
        ],
        axis=1,
    )
    parts.append(mesh.Part(f"{name}_rim", both, quads, rim_uv % 1.0, "torn"))
    return parts


def _rim(faces):
    """Directed edges (E, 2) that belong to one face only."""
    edges = np.concatenate([np.stack([faces[:, k], faces[:, (k + 1) % 4]], axis=1) for k in range(4)])
    key = np.sort(edges, axis=1)
    code = key[:, 0].astype(np.int64) * (key.max() + 1) + key[:, 1]
    _, first, count = np.unique(code, return_index=True, return_counts=True)
    return edges[first[count == 1]]


def _inside(s, rng):
    """What the tear lays open: decks, boxes, a tank, loose cables, a bent strut."""
    parts = [
        mesh.sphere("tank", [-0.12 * s, 0.18 * s, -0.16 * s], 0.185 * s, "tank", 40, 20),
        mesh.box("deck", [-0.47 * s, -0.47 * s, 0.03 * s], [0.05 * s, 0.47 * s, 0.05 * s], "inner", 0.002 * s),
        mesh.box("computer", [-0.40 * s, -0.38 * s, 0.05 * s], [-0.05 * s, -0.06 * s, 0.26 * s], "box_black", 0.008 * s),
        mesh.box("radio", [-0.35 * s, 0.02 * s, 0.05 * s], [-0.02 * s, 0.34 * s, 0.17 * s], "box_white", 0.006 * s),
        mesh.box("battery", [-0.40 * s, -0.40 * s, -0.44 * s], [-0.02 * s, -0.10 * s, -0.22 * s], "box_green", 0.008 * s),
        mesh.cylinder("wheel", [-0.18 * s, -0.22 * s, -0.20 * s], [-0.18 * s, -0.22 * s, -0.08 * s], 0.10 * s, "metal", 36),
        mesh.cylinder("strut", [-0.42 * s, 0.42 * s, 0.42 * s], [0.22 * s, 0.30 * s, 0.24 * s], 0.012 * s, "metal", 12),
    ]
    for k in range(4):
        z = (0.29 + 0.04 * k) * s
        parts.append(mesh.box(f"board_{k}", [-0.36 * s, -0.36 * s, z], [-0.06 * s, -0.08 * s, z + 0.004 * s], "board"))
    for k in range(9):
        start = np.array([rng.uniform(-0.2, -0.05), rng.uniform(-0.35, 0.35), rng.uniform(0.0, 0.3)])
        drift = np.array([rng.uniform(0.2, 0.48), rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2)])
        t = np.linspace(0, 1, 30)[:, None]
        swing = 0.05 * np.sin(t * rng.uniform(4, 10, 3) + rng.uniform(0, 6, 3)) * t
        parts.append(mesh.tube(f"cable_{k}", (start + drift * t + swing) * s, 0.006 * s, f"cable_{k % 3}"))
    return parts


def _outside(s):
    """A few fittings on the sound sides."""
    h = s / 2
    parts = [
        mesh.cylinder("dish_foot", [-h, 0.15 * s, 0.1 * s], [-h - 0.05 * s, 0.15 * s, 0.1 * s], 0.03 * s, "metal", 20),
        mesh.lathe(
            "dish",
            np.array(
                [
                    (0.05, 0.0),
                    (0.055, 0.05),
                    (0.07, 0.10),
                    (0.095, 0.14),
                    (0.10, 0.14),
                    (0.075, 0.10),
                    (0.06, 0.05),
                    (0.055, 0.0),
                ]
            )
            * s,
            [-h, 0.15 * s, 0.1 * s],
            [-1, 0, 0],
            "dish",
            48,
        ),
        mesh.box("sensor", [-0.35 * s, -0.30 * s, h], [-0.20 * s, -0.18 * s, h + 0.06 * s], "box_white", 0.006 * s),
        mesh.cylinder("baffle", [-0.10 * s, 0.25 * s, h], [-0.10 * s, 0.25 * s, h + 0.09 * s], 0.055 * s, "black", 32),
        mesh.box("hinge_a", [-0.30 * s, -h - 0.03 * s, -0.36 * s], [-0.24 * s, -h, -0.26 * s], "metal", 0.005 * s),
        mesh.box("hinge_b", [-0.30 * s, -h - 0.03 * s, 0.26 * s], [-0.24 * s, -h, 0.36 * s], "metal", 0.005 * s),
    ]
    for k, (y, z) in enumerate(((0.4, 0.4), (-0.4, 0.4), (0.4, -0.4), (-0.4, -0.4))):
        bell = np.array([(0, 0.012), (0.02, 0.014), (0.045, 0.03), (0.045, 0.027), (0.005, 0.008)]) * s
        parts.append(mesh.lathe(f"thruster_{k}", bell, [-h, y * s, z * s], [-1, 0, 0], "metal", 24))
    return parts


def _inner_skin(shape, unit, rng):
    """Primer-yellow inner face with a grid of inserts and burn marks."""
    skin = surfaces.plate(shape, unit, rng, (0.55, 0.56, 0.36), (), metallic=0.2, panels=False, wear=1.6, decals=False)
    burn = np.clip(noise.fractal(shape, rng, 2.6, 0.3 * unit), 0, 2)[..., None]
    skin.color = np.clip(skin.color * (1 - 0.4 * burn), 0, 1)
    return skin


def _honeycomb(rng):
    """Bare crushed core."""
    shape = (64, 2048)
    crush = noise.fractal(shape, rng, 1.0, 20)
    color = np.clip(0.62 + 0.18 * crush, 0, 1)[..., None] * np.ones(3)
    return Material(color.astype(np.float32), 0.4, 0.6, slopes_from_height(0.8 * crush))


def _materials(s, seed, texture_px):
    unit = texture_px
    shape = (texture_px * 3 // 4, texture_px * 3 // 4)
    unit = unit * 3 / 4
    rng = [noise.generator(seed, 60 + n) for n in range(14)]
    return {
        "x_plus": surfaces.plate(shape, unit, rng[0], (0.75, 0.75, 0.73), ("BUS 7",)),
        "x_minus": surfaces.plate(shape, unit, rng[1], (0.80, 0.80, 0.77), ("DEBRIS 7", "SN 0042", "REMOVE")),
        "y_plus": surfaces.foil(shape, unit, rng[2], surfaces.GOLD, 0.06),
        "y_minus": surfaces.solar_cells(shape, unit, rng[3], (0.07, 0.125)),
        "z_plus": surfaces.plate(shape, unit, rng[4], (0.60, 0.59, 0.56), ("PANEL Z", "TCS"), metallic=0.5),
        "z_minus": surfaces.foil(shape, unit, rng[5], surfaces.SILVER, 0.06),
        "inner": _inner_skin(shape, unit, rng[6]),
        "torn": _honeycomb(rng[7]),
        "box_white": surfaces.plate((256, 256), 700, rng[8], (0.8, 0.8, 0.78), ("R1",), panels=False),
        "box_black": surfaces.plate((256, 256), 700, rng[9], (0.16, 0.16, 0.17), (), panels=False, decals=False),
        "box_green": surfaces.plate((256, 256), 700, rng[10], (0.32, 0.45, 0.36), (), panels=False, decals=False),
        "board": surfaces.plate((256, 256), 900, rng[11], (0.10, 0.32, 0.16), (), panels=False, decals=False, wear=3),
        "dish": Material((0.82, 0.82, 0.80), 0.6),
        "tank": Material((0.70, 0.66, 0.60), 0.28, 0.85),
        "metal": Material((0.72, 0.72, 0.73), 0.30, 0.9),
        "black": Material((0.09, 0.09, 0.095), 0.55),
        "cable_0": Material((0.72, 0.66, 0.58), 0.5),
        "cable_1": Material((0.62, 0.18, 0.12), 0.5),
        "cable_2": Material((0.78, 0.78, 0.78), 0.5),
    }
