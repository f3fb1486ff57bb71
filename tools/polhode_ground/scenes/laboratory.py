"""A furnished laboratory around a table, at rest in I: the distracting background of a test bed.

Frame L: x to the right, y away from the camera, z up, origin on the table top below the target's first position.
The room is rendered once per camera attitude as a picture of its own; per frame only the target is rendered, and, on a
coarse grid, the table's light with and without the target above it, whose ratio darkens the picture: the lamps are wide,
so the shadow is soft. Two soft lamps overhead and an even ambient light serve both.
"""

import numpy as np

from . import mesh, noise, surfaces
from .black_space import Empty
from .materials import Material
from .rotations import quat_to_matrix

ROOM_SAMPLES = 96
# The shadow's grid: about this many columns across the picture, so that the narrowest penumbra covers three of them.
SHADOW_COLUMNS = 400
SHADOW_SAMPLES = 32
AMBIENT = 0.35
# Irradiance of each lamp straight below it, relative to the sun's; place (x, y, z) and width in bodies.
LAMPS = ((1.1, (-5.0, -4.0, 11.0), 4.0), (0.55, (6.0, 1.0, 12.0), 3.0))


class Laboratory(Empty):
    """The room's picture behind the target."""

    own_light = True

    def __init__(self, plan, resampler, blender, scratch_path, vertices_T):
        settings = plan.scene["background"]
        self.plan, self.resampler, self.blender, self.scratch_path = plan, resampler, blender, scratch_path
        first_I = plan.R_IC0 @ np.asarray(plan.scene["motion"]["p_CT0_m"], dtype=float)
        up_I = plan.R_IC0 @ np.asarray(settings["up_C"], dtype=float)
        up_I /= np.linalg.norm(up_I)
        away_I = first_I - np.dot(first_I, up_I) * up_I
        away_I /= np.linalg.norm(away_I)
        # Columns: axes of L in I.
        self.R_IL = np.stack([np.cross(away_I, up_I), away_I, up_I], axis=1)
        self.origin_I_m = first_I - settings["table_below_m"] * up_I
        self.size_m = plan.scene["target"]["size_m"]
        parts, materials = furniture(settings["seed"], self.size_m)
        self.room = blender.add_parts(parts, materials, "laboratory")
        self.table = blender.child_named(self.room, "table_top")
        self.matt = blender.make_material("matt_table", Material((0.45, 0.45, 0.45), 1.0, specular=0.0))
        blender.add_ambient(AMBIENT)
        for strength, place, width in LAMPS:
            blender.add_lamp(self.room, np.array(place) * self.size_m, width * self.size_m, strength)
        self.box_T = np.array(np.meshgrid(*np.stack([vertices_T.min(axis=0), vertices_T.max(axis=0)], axis=1)))
        self.box_T = self.box_T.reshape(3, -1).T
        self.coarseness = max(1, round(plan.camera.width / SHADOW_COLUMNS))
        self.picture, self.picture_q_IC = None, None

    def _shadow_reach(self, R_CI):
        """Points in C (N, 3) around all shadows on the table: below the target and away from each lamp."""
        R_CL, origin_C = R_CI @ self.R_IL, R_CI @ self.origin_I_m
        motion, shadows = self.plan.sub_motion, []
        for row in range(len(motion.time_s)):
            R_IC = quat_to_matrix(motion.q_IC[row])
            p_I = (self.box_T @ motion.R_CT(row).T + motion.p_CT_m[row]) @ R_IC.T
            p_L = (p_I - self.origin_I_m) @ self.R_IL
            # The soft shadow of the ambient light is too faint to see a third of a body away.
            around = 0.33 * self.size_m * np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]])
            shadows += [p_L * [1, 1, 0] + step for step in around]
            for _, place, _ in LAMPS:
                lamp = np.array(place) * self.size_m
                height = np.clip(p_L[:, 2:], 0, 0.8 * lamp[2])
                shadows.append((p_L + (p_L - lamp) * height / (lamp[2] - height)) * [1, 1, 0])
        return np.concatenate(shadows) @ R_CL.T + origin_C

    def prepare(self, motion, row):
        """Puts the room where the camera sees it at this row; renders its picture if the view has changed."""
        q_IC = motion.q_IC[row]
        if self.picture is not None and np.allclose(q_IC, self.picture_q_IC, atol=1e-12):
            return
        self.picture_q_IC = q_IC.copy()
        R_CI = quat_to_matrix(q_IC).T
        self.blender.place(self.room, R_CI @ self.R_IL, R_CI @ self.origin_I_m)
        window = self.resampler.full_window()
        camera = self.plan.camera
        with self.blender.room_only(self.room, self.table, ROOM_SAMPLES):
            picture = self.blender.render_window(
                self.resampler.f_ideal, camera.cu, camera.cv, window, self.plan.scene["seed"], self.scratch_path
            )
        self.picture = self.resampler.to_camera(picture, window)[..., :3]
        self.shadow_window = self.resampler.target_window(self._shadow_reach(R_CI))
        if self.shadow_window is None:
            return
        with self.blender.table_only(self.table, self.matt, SHADOW_SAMPLES, shadowed=False):
            self.table_cover = self.blender.render_window(
                self.resampler.f_ideal, camera.cu, camera.cv, self.shadow_window, 1, self.scratch_path
            )[..., 3:]
            self.unshadowed = self._table_light()

    def _table_light(self):
        """Linear RGB (H, W, 3) of the matt table over the shadow window, spread over a coarse pixel's surroundings."""
        x0, y0, width, height = self.shadow_window
        coarse = [n // self.coarseness for n in (x0, y0)]
        coarse += [-(-n // self.coarseness) - c for n, c in zip((x0 + width, y0 + height), coarse)]
        camera, n = self.plan.camera, self.coarseness
        # One seed for all: without noise of its own, the ratio is 1 wherever the target is not in the way.
        picture = self.blender.render_window(
            self.resampler.f_ideal / n,
            (camera.cu + 0.5) / n - 0.5,
            (camera.cv + 0.5) / n - 0.5,
            coarse,
            self.plan.scene["seed"],
            self.scratch_path,
        )[..., :3]
        for axis in (0, 1):
            picture = _smoothed(picture, axis)
        v, u = (
            (np.arange(start, start + count) + 0.5) / n - 0.5 - first
            for start, count, first in ((y0, height, coarse[1]), (x0, width, coarse[0]))
        )
        return _stretched(_stretched(picture, v, 0), u, 1)

    def radiance(self, motion, row):
        """Linear RGB (H, W, 3) of the room with the target's shadow; the target is where it was rendered last."""
        del motion, row
        if self.shadow_window is None:
            return self.picture
        with self.blender.table_only(self.table, self.matt, SHADOW_SAMPLES, shadowed=True):
            light = self._table_light() / np.maximum(self.unshadowed, 1e-6)
        darkening = self.table_cover * (1 - light)
        return self.picture * (1 - self.resampler.to_camera(darkening, self.shadow_window))


def _smoothed(image, axis):
    """Binomial mean of five neighbours along an axis, the edges repeated."""
    wide = np.pad(image, [(2, 2) if a == axis else (0, 0) for a in range(image.ndim)], mode="edge")
    count = image.shape[axis]
    return sum(w * np.take(wide, range(k, k + count), axis) for k, w in enumerate((1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16)))


def _stretched(image, where, axis):
    """Linear interpolation along an axis at pixel coordinates where (N,), the edges repeated."""
    last = image.shape[axis] - 1
    low = np.clip(np.floor(where).astype(int), 0, last)
    high = np.minimum(low + 1, last)
    share = np.clip(where - low, 0, 1).astype(np.float32).reshape([-1 if a == axis else 1 for a in range(image.ndim)])
    return np.take(image, low, axis) * (1 - share) + np.take(image, high, axis) * share


def furniture(seed, body_size_m):
    """Parts and materials of the room in L, sized for a body of body_size_m on a table 9 bodies wide."""
    unit = body_size_m
    rng = noise.generator(seed, 31)
    parts = [
        mesh.box("table_top", [-4.5 * unit, -3 * unit, -0.2 * unit], [4.5 * unit, 3.2 * unit, 0], "table", 0.05 * unit),
        *_room(unit),
        *_shelves(unit, rng),
        *_bench(unit, rng),
    ]
    return parts, _materials(seed)


def _room(unit):
    """Floor, back wall, white board, posters, a door. The other walls are left out: light comes in from there."""
    w, d, h, low = 22 * unit, 18 * unit, 14 * unit, -8 * unit
    return [
        mesh.grid_patch("floor", [-w, -d, low], [2 * w, 0, 0], [0, 2 * d, 0], (1, 1), "floor"),
        mesh.grid_patch("back_wall", [-w, d, low], [2 * w, 0, 0], [0, 0, h - low], (1, 1), "wall"),
        mesh.box(
            "board",
            [-7.5 * unit, d - 0.4 * unit, -0.5 * unit],
            [0 * unit, d - 0.1 * unit, 4.5 * unit],
            "whiteboard",
            0.1 * unit,
        ),
        mesh.box("poster_a", [1.0 * unit, d - 0.3 * unit, -1.2 * unit], [4.5 * unit, d - 0.1 * unit, 4 * unit], "poster_a"),
        mesh.box("poster_b", [6.5 * unit, d - 0.3 * unit, 1 * unit], [11 * unit, d - 0.1 * unit, 5.5 * unit], "poster_b"),
        mesh.box("door", [13 * unit, d - 0.3 * unit, low], [19 * unit, d - 0.1 * unit, 5 * unit], "door", 0.1 * unit),
    ]


def _shelves(unit, rng):
    """Two racks of shelves with boxes of all kinds against the back wall."""
    parts = []
    for side, x0 in enumerate((-19.5, -13.3)):
        for level in range(5):
            z = (-7.5 + 3.2 * level) * unit
            parts.append(
                mesh.box(
                    f"shelf_{side}_{level}",
                    [x0 * unit, 13 * unit, z],
                    [(x0 + 6) * unit, 17 * unit, z + 0.2 * unit],
                    "door",
                )
            )
            x = x0 + 0.2
            while x < x0 + 5.2:
                width, height = rng.uniform(0.5, 1.5), rng.uniform(0.8, 2.6)
                parts.append(
                    mesh.box(
                        f"item_{side}_{level}_{x:.1f}",
                        [x * unit, rng.uniform(13.1, 14.2) * unit, z + 0.2 * unit],
                        [(x + width) * unit, 16.5 * unit, z + (0.2 + height) * unit],
                        f"item_{rng.integers(0, 6)}",
                        0.05 * unit,
                    )
                )
                x += width + rng.uniform(0.05, 0.5)
    return parts


def _bench(unit, rng):
    """A bench with screens, instruments and a lattice of profile bars right of the table."""
    parts = [mesh.box("bench", [4.8 * unit, 11 * unit, -2.4 * unit], [20 * unit, 16 * unit, -2 * unit], "table", 0.05 * unit)]
    for k, x in enumerate((5.6, 9.6)):
        parts.append(
            mesh.box(
                f"screen_{k}",
                [x * unit, 13.5 * unit, -1.2 * unit],
                [(x + 3) * unit, 13.8 * unit, 0.8 * unit],
                "screen",
                0.05 * unit,
            )
        )
        parts.append(
            mesh.box(
                f"foot_{k}",
                [(x + 1.3) * unit, 13.5 * unit, -2 * unit],
                [(x + 1.7) * unit, 13.9 * unit, -1.2 * unit],
                "door",
            )
        )
    for k in range(9):
        x, y = rng.uniform(5, 16), rng.uniform(11.3, 13)
        size = rng.uniform(0.4, 1.2, 3)
        parts.append(
            mesh.box(
                f"tool_{k}",
                [x * unit, y * unit, -2 * unit],
                [(x + size[0]) * unit, (y + size[1]) * unit, (-2 + size[2]) * unit],
                f"item_{rng.integers(0, 6)}",
                0.05 * unit,
            )
        )
    for x in (-8.6, 8.4):
        parts.append(mesh.box("post", [x * unit, 6 * unit, -8 * unit], [(x + 0.4) * unit, 6.4 * unit, 9 * unit], "bar", 0.04 * unit))
    parts.append(mesh.box("beam", [-8.6 * unit, 6 * unit, 8.6 * unit], [8.8 * unit, 6.4 * unit, 9 * unit], "bar", 0.04 * unit))
    for k in range(3):
        x = -10.0 + 1.4 * k
        parts.append(
            mesh.cylinder(
                f"flask_{k}",
                [x * unit, 12 * unit, -8 * unit],
                [x * unit, 12 * unit, (-4 + k) * unit],
                0.55 * unit,
                f"item_{k}",
                28,
            )
        )
    return parts


def _materials(seed):
    def plate(n, color, text=(), shape=(512, 512), unit=900, **options):
        return surfaces.plate(shape, unit, noise.generator(seed, 32, n), color, text, **options)

    made = {
        "table": plate(0, (0.42, 0.43, 0.45), panels=False, decals=False, wear=1.0, shape=(1024, 1024), unit=700),
        "floor": surfaces.weave((1024, 1024), 9000, noise.generator(seed, 33), (0.42, 0.43, 0.42)),
        "wall": plate(1, (0.66, 0.67, 0.66), panels=False, decals=False, wear=1.0, shape=(512, 1024)),
        "whiteboard": plate(3, (0.85, 0.85, 0.86), ("I W - W X I W", "T 0 1 2 3 4", "SFM / PNP"), panels=False, wear=2.0, unit=500),
        "poster_a": surfaces.solar_cells((512, 384), 900, noise.generator(seed, 34), (0.11, 0.16)),
        "poster_b": plate(4, (0.55, 0.50, 0.36), ("LAB 3", "ORBIT", "DEBRIS"), wear=4.0),
        "door": plate(5, (0.45, 0.41, 0.36), panels=True, decals=False),
        "screen": plate(6, (0.14, 0.17, 0.22), ("RUN 12", "OK"), panels=False),
        "bar": Material((0.62, 0.63, 0.65), 0.35, 0.8),
    }
    colors = (
        (0.55, 0.42, 0.28),
        (0.22, 0.34, 0.50),
        (0.70, 0.70, 0.68),
        (0.50, 0.18, 0.14),
        (0.20, 0.21, 0.22),
        (0.32, 0.45, 0.30),
    )
    for n, color in enumerate(colors):
        made[f"item_{n}"] = plate(10 + n, color, (f"BOX {n}", "PARTS"), panels=n % 2 == 0, wear=2.0, unit=500)
    return made
