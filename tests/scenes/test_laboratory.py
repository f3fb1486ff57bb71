"""The laboratory's shadow: where it lies and what it leaves alone. A stand-in plays Blender."""

import contextlib

import numpy as np
import pytest
from polhode_ground.scenes import camera as cam
from polhode_ground.scenes import laboratory, pipeline, scene_file

# Light on the table is halved within a disc about this point of the table plane.
SPOT_C_M = np.array([0.03, 0.09, 0.45])
SPOT_RADIUS_M = 0.05


class StandIn:
    """Draws a bright plane y = 0.09 in C below the horizon, darker in the disc while the target throws a shadow."""

    def __init__(self):
        self.shadowed, self.rooms = False, 0

    def add_parts(self, *_):
        return None

    def child_named(self, *_):
        return None

    def make_material(self, *_):
        return None

    def add_ambient(self, _):
        pass

    def add_lamp(self, *_):
        pass

    def place(self, *_):
        pass

    @contextlib.contextmanager
    def room_only(self, *_):
        self.rooms += 1
        yield

    @contextlib.contextmanager
    def table_only(self, _room, _matt, _samples, shadowed):
        self.shadowed = shadowed
        yield
        self.shadowed = False

    def render_window(self, f_px, cu, cv, window, seed, _path):
        x0, y0, width, height = window
        u, v = np.meshgrid(np.arange(x0, x0 + width), np.arange(y0, y0 + height))
        x, y = (u - cu) / f_px, (v - cv) / f_px
        cover = (y > 0.1).astype(np.float32)
        z_m = SPOT_C_M[1] / np.maximum(y, 1e-3)
        in_disc = np.hypot(x * z_m - SPOT_C_M[0], z_m - SPOT_C_M[2]) < SPOT_RADIUS_M
        # Grain of the renderer: the same for the same seed and pixel, as Cycles has it.
        grain = 1 + 0.3 * np.random.default_rng(seed).standard_normal((height, width))
        light = cover * grain * np.where(in_disc & self.shadowed, 0.5, 1.0)
        return np.stack([light, light, light, cover], axis=-1).astype(np.float32)


def _plan(camera):
    return pipeline.Plan(
        scene_file.check(
            {
                "target": {"kind": "cubesat", "size_m": 0.15},
                "motion": {
                    "inertia_kg_m2": [1, 1, 1],
                    "w0_T_deg_s": [0, 0, 9.0],
                    "q_CT0": [1, 0, 0, 0],
                    "p_CT0_m": [0, 0, 0.45],
                },
                "camera": {"resolution": [1600, 900], "lens_mm": 28.0, **camera},
                "time": {"frames": 2, "period_s": 0.1},
                "background": {"kind": "laboratory", "up_C": [0.0, -1.0, 0.0], "table_below_m": 0.09},
            }
        )
    )


@pytest.mark.parametrize("distortion", [[0.0, 0.0, 0.0, 0.0], [-0.12, 0.03, 0.001, -0.001]])
def test_the_shadow_lies_where_the_light_is_missing(distortion):
    plan, blender = _plan({"distortion": distortion}), StandIn()
    vertices_T = 0.075 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    room = laboratory.Laboratory(plan, cam.Resampler(plan.camera), blender, "", vertices_T)
    for row in (0, 1):
        room.prepare(plan.sub_motion, row)
    assert blender.rooms == 1
    shade = (room.radiance(plan.sub_motion, 0) / np.where(room.picture == 0, 1, room.picture))[..., 0]
    on_table = room.picture[..., 0] != 0
    xy = cam.pixel_rays(plan.camera, *np.meshgrid(np.arange(1600.0), np.arange(900.0)))
    z_m = SPOT_C_M[1] / np.maximum(xy[..., 1], 1e-3)
    from_spot_m = np.hypot(xy[..., 0] * z_m - SPOT_C_M[0], z_m - SPOT_C_M[2])
    # A coarse pixel of 4 px and its four neighbours either way smear the edge by 12 to 15 px: 6 mm across and 31 mm in depth.
    inside, outside = from_spot_m < SPOT_RADIUS_M - 0.035, from_spot_m > SPOT_RADIUS_M + 0.035
    assert (on_table & inside).sum() > 1000
    assert np.abs(shade[on_table & inside] - 0.5).max() < 1e-3
    assert np.array_equal(shade[on_table & outside], np.ones((on_table & outside).sum(), dtype=np.float32))
    # Half a coarse pixel, the usual mistake, would show as a shift of the missing light's centre.
    missing = np.where(on_table, 1 - shade, 0)
    found = np.array([(missing * axis).sum() for axis in np.meshgrid(np.arange(1600.0), np.arange(900.0))]) / missing.sum()
    sharp = on_table & (from_spot_m < SPOT_RADIUS_M)
    expected = np.argwhere(sharp).mean(axis=0)[::-1]
    assert np.abs(found - expected).max() < 0.5


def test_a_picture_that_is_stretched_keeps_ramps_and_constants():
    ramp = np.tile(np.arange(10.0, dtype=np.float32)[:, None], (1, 3))
    where = np.linspace(0.0, 9.0, 37)
    assert np.allclose(laboratory._stretched(ramp, where, 0)[:, 1], where, atol=1e-6)
    assert np.allclose(laboratory._smoothed(ramp, 0)[2:-2], ramp[2:-2], atol=1e-6)
    assert np.allclose(laboratory._smoothed(np.ones((4, 5), dtype=np.float32), 1), 1)
