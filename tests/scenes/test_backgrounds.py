"""Stars and the Earth: directions, not looks."""

import numpy as np
import pytest
from polhode_ground.scenes import backgrounds, pipeline, scene_file
from polhode_ground.scenes import camera as cam
from polhode_ground.scenes.rotations import quat_to_matrix


def _plan(background, camera=None, light=None):
    return pipeline.Plan(
        scene_file.check(
            {
                "target": {"kind": "box"},
                "motion": {
                    "inertia_kg_m2": [1, 1, 1],
                    "w0_T_deg_s": [0, 0, 1.0],
                    "q_CT0": [1, 0, 0, 0],
                    "p_CT0_m": [0, 0, 5.0],
                },
                "camera": {"resolution": [320, 240], "intrinsics_px": [400.0, 400.0, 159.5, 119.5], **(camera or {})},
                "time": {"frames": 3, "period_s": 10.0},
                "background": background,
                "light": light or {},
            }
        )
    )


@pytest.mark.parametrize("distortion", [[0.0, 0.0, 0.0, 0.0], [-0.2, 0.05, 0.001, -0.001]])
def test_stars_stand_still_in_inertial_space_while_the_camera_turns(distortion):
    plan = _plan({"kind": "stars", "stars": 8000}, {"w_C_deg_s": [0.3, 0.2, 0.5], "distortion": distortion})
    stars = backgrounds.make(plan, None, None, None, None)
    for row in (0, 2):
        image = stars.radiance(plan.motion, row)[..., 0]
        d_C = stars.direction_I @ quat_to_matrix(plan.motion.q_IC[row])
        ahead = d_C[:, 2] > 0.5
        uv = cam.project(plan.camera, d_C[ahead])
        inside = np.all((uv > 8) & (uv < [311, 231]), axis=1)
        lonely = [p for p in uv[inside] if np.sum(np.linalg.norm(uv - p, axis=1) < 12) == 1]
        assert len(lonely) > 10
        for u, v in lonely:
            u0, v0 = int(round(u)), int(round(v))
            patch = image[v0 - 3 : v0 + 4, u0 - 3 : u0 + 4]
            yy, xx = np.mgrid[-3:4, -3:4]
            centre = np.array([u0 + (patch * xx).sum() / patch.sum(), v0 + (patch * yy).sum() / patch.sum()])
            # The patch is cut at 3 px = 4 deviations of the spot, off centre by up to half a pixel.
            assert np.abs(centre - [u, v]).max() < 0.02


def test_the_limb_is_where_the_altitude_puts_it():
    altitude_km = 520.0
    radius = np.arcsin(backgrounds.EARTH_RADIUS_KM / (backgrounds.EARTH_RADIUS_KM + altitude_km))
    # The centre of the Earth lies below the boresight by its angular radius, so the limb crosses the image's middle.
    light = {"earth_direction_C": [0.0, np.sin(radius), np.cos(radius)], "sun_direction_C": [0.0, -0.3, -1.0]}
    background = {"kind": "earth", "stars": 0, "altitude_km": altitude_km, "orbit_rate_deg_s": 0.05}
    plan = _plan(background, light=light)
    earth = backgrounds.make(plan, None, None, None, None)
    column = earth.radiance(plan.motion, 0)[:, 160].sum(axis=1)
    assert np.all(np.isfinite(column)) and column[120:].min() > 0.02
    # Above the limb there is only a glow that fades: 14 km at 2600 km of distance are 0.31 deg or 2.2 px.
    assert column[:90].max() < 1e-3 and np.all(np.diff(column[90:119]) >= 0)


def test_the_earth_turns_with_the_orbit():
    plan = _plan({"kind": "earth", "stars": 0, "orbit_rate_deg_s": 0.05, "orbit_normal_C": [1.0, 0.0, 0.0]})
    first, later = plan.earth_direction_I(0.0), plan.earth_direction_I(200.0)
    across = [d - d[0] * np.array([1.0, 0, 0]) for d in (first, later)]
    cosine = np.dot(*across) / np.prod([np.linalg.norm(d) for d in across])
    assert np.isclose(np.degrees(np.arccos(cosine)), 10.0)
    # With another background the Earth only lights and stays put.
    assert np.allclose(_plan({"kind": "none"}).earth_direction_I(200.0), _plan({"kind": "none"}).earth_direction_I(0.0))
