"""Every model of lens against formulas that are written down here again, and COLMAP's against its own library."""

import json
import subprocess

import numpy as np
import pytest
from made_sources import REPOSITORY

INTRINSICS = (300.0, 305.0, 310.0, 230.0)
FAR_PX = 1e-3  # float32 holds a place of some hundred pixels to 3e-5


def pixels(plane):
    return plane * INTRINSICS[:2] + INTRINSICS[2:]


def tilted(plane, tx, ty):
    """A sensor that is turned about x, then y, seen along its own axis (OpenCV, calib3d)."""
    about_x = np.array([[1, 0, 0], [0, np.cos(tx), np.sin(tx)], [0, -np.sin(tx), np.cos(tx)]])
    about_y = np.array([[np.cos(ty), 0, -np.sin(ty)], [0, 1, 0], [np.sin(ty), 0, np.cos(ty)]])
    turn = about_y @ about_x
    seen = np.column_stack([plane, np.ones(len(plane))]) @ turn.T
    return np.column_stack([turn[2, 2] * seen[:, 0] - turn[0, 2] * seen[:, 2], turn[2, 2] * seen[:, 1] - turn[1, 2] * seen[:, 2]]) / seen[:, 2:]


def brown(x, y, k1, k2, p1, p2, k3=0.0, k4=0.0, k5=0.0, k6=0.0, s1=0.0, s2=0.0, s3=0.0, s4=0.0, tx=0.0, ty=0.0):
    r2 = x**2 + y**2
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    return tilted(np.column_stack([x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2) + s1 * r2 + s2 * r2**2,
                                   y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y + s3 * r2 + s4 * r2**2]), tx, ty)


def radial_of(x, y, radius):
    """radius: of the ray's tangent, as it is seen."""
    r = np.hypot(x, y)
    return np.column_stack([x, y]) * (radius(r) / np.maximum(r, 1e-12))[:, None]


def equidistant(x, y, k1, k2, k3, k4):
    return radial_of(x, y, lambda r: np.arctan(r) * np.polyval([k4, k3, k2, k1, 1], np.arctan(r)**2))


def omni(x, y, xi, *distortion):
    length = np.sqrt(x**2 + y**2 + 1)
    return brown(x / (1 + xi * length), y / (1 + xi * length), *distortion)


def double_sphere(x, y, xi, alpha):
    z = 1 + xi * np.sqrt(x**2 + y**2 + 1)
    return np.column_stack([x, y]) / (alpha * np.hypot(np.hypot(x, y), z) + (1 - alpha) * z)[:, None]


def unified(x, y, alpha, beta):
    return np.column_stack([x, y]) / (alpha * np.sqrt(beta * (x**2 + y**2) + 1) + 1 - alpha)[:, None]


def fov(x, y, omega):
    return radial_of(x, y, lambda r: np.arctan(2 * r * np.tan(omega / 2)) / omega)


FOURTEEN = (-0.2, 0.05, 0.001, -0.002, 0.01, 0.1, 0.02, 0.003, 0.002, -0.001, 0.001, 0.0005, 0.02, -0.015)


def compare(undistorter, expected):
    """Where the pictures are taken from, for pixels here and there. @param expected  pixels of directions x / z, y / z"""
    fu, fv, cu, cv = undistorter.lens.intrinsics_px
    v, u = (part.ravel() for part in np.mgrid[0:480:31, 0:640:31])
    found = np.column_stack([part[v, u] for part in undistorter._maps])
    assert np.abs(found - expected((u - cu) / fu, (v - cv) / fv)).max() < FAR_PX
    assert (found > -0.6).all() and (found < (639.6, 479.6)).all()  # no edge is empty


# verifies: GND-03
@pytest.mark.parametrize(("name", "formula", "coefficients"), [
    ("plumb_bob", brown, FOURTEEN[:5]), ("rational_polynomial", brown, FOURTEEN[:8]), ("thin_prism", brown, FOURTEEN[:12]),
    ("thin_prism", brown, FOURTEEN), ("equidistant", equidistant, (0.05, -0.01, 0.002, -0.001)), ("fov", fov, (0.9,)),
    ("omni", omni, (1.2, -0.1, 0.02, 0.001, -0.001)), ("ds", double_sphere, (-0.2, 0.59)), ("eucm", unified, (0.6, 1.1)),
], ids=["5", "rational", "thin prism", "tilted", "equidistant", "fov", "omni", "double sphere", "eucm"])
def test_pictures_are_taken_from_where_the_model_sees_them(name, formula, coefficients):
    from polhode_ground.importing.lens import lens_of
    from polhode_ground.importing.undistorting import Undistorter
    lens = lens_of(640, 480, INTRINSICS, name, coefficients, "file")
    compare(Undistorter(lens, "file"), lambda x, y: pixels(formula(x, y, *coefficients)))


PARAMS = [300.0, 305.0, 310.5, 230.5]  # COLMAP's pixel centres lie at + 0.5
BY_COLMAP = {
    "SIMPLE_PINHOLE": [300.0, 310.5, 230.5], "PINHOLE": PARAMS, "SIMPLE_RADIAL": [300.0, 310.5, 230.5, -0.05], "RADIAL": [300.0, 310.5, 230.5, -0.05, 0.01],
    "OPENCV": [*PARAMS, -0.05, 0.01, 0.001, -0.002], "FULL_OPENCV": [*PARAMS, *FOURTEEN[:8]], "OPENCV_FISHEYE": [*PARAMS, 0.05, -0.01, 0.002, -0.001],
    "SIMPLE_RADIAL_FISHEYE": [300.0, 310.5, 230.5, 0.05], "RADIAL_FISHEYE": [300.0, 310.5, 230.5, 0.05, -0.01], "SIMPLE_FISHEYE": [300.0, 310.5, 230.5],
    "FISHEYE": PARAMS, "FOV": [*PARAMS, 0.9], "EUCM": [*PARAMS, 0.6, 1.1], "SIMPLE_DIVISION": [300.0, 310.5, 230.5, -0.2], "DIVISION": [*PARAMS, -0.2],
    "THIN_PRISM_FISHEYE": [*PARAMS, 0.05, -0.01, 0.001, -0.002, 0.003, 0.001, 0.002, -0.001],
    "RAD_TAN_THIN_PRISM_FISHEYE": [*PARAMS, 0.05, -0.01, 0.003, 0.001, 0, 0, 0.001, -0.002, 0.002, -0.001, 0.001, 0], "EQUIRECTANGULAR": [640, 480],
}
ASK = """import json, sys, numpy, pycolmap
rays = numpy.array(json.load(sys.stdin))
known = [name for name in pycolmap.CameraModelId.__members__ if name != "INVALID"]
places = {name: pycolmap.Camera(model=name, width=640, height=480, params=params).img_from_cam(rays).tolist() for name, params in json.loads(sys.argv[1]).items()}
print(json.dumps([known, places]))"""


@pytest.mark.further
@pytest.mark.skipif(not (REPOSITORY / ".venv-colmap/bin/python3").exists(), reason="COLMAP is not set up: tools/setup.sh colmap")
def test_colmap_sees_with_each_of_its_models_what_we_do():
    from polhode_ground.importing.colmap_lens import lens_of_camera
    v, u = (part.ravel() for part in np.mgrid[-0.6:0.6:9j, -0.8:0.8:9j])
    rays = np.column_stack([u, v, np.ones(len(u))])
    done = subprocess.run([REPOSITORY / ".venv-colmap/bin/python3", "-c", ASK, json.dumps(BY_COLMAP)], input=json.dumps(rays.tolist()),
                          capture_output=True, text=True, check=True)
    known, places = json.loads(done.stdout.splitlines()[-1])
    assert sorted(known) == sorted(BY_COLMAP)
    for name, params in BY_COLMAP.items():
        lens = lens_of_camera({"model": name, "width": 640, "height": 480, "params": params}, "project")
        assert np.abs(lens.project(rays) - (np.array(places[name]) - 0.5)).max() < 1e-6, name


def test_a_model_that_folds_back_is_followed_to_the_fold_only():
    from polhode_ground.importing.lens import lens_of
    from polhode_ground.importing.undistorting import Undistorter
    fold = 1 / np.sqrt(3 * 0.5)  # where r (1 - 0.5 r^2) is largest
    # With k3, however small, the lens is none of those that stay as they are.
    undistorter = Undistorter(lens_of(640, 480, INTRINSICS, "", (-0.5, 0, 0, 0, 1e-18), "file"), "file")
    fu, fv, cu, cv = undistorter.lens.intrinsics_px
    corner = max(np.hypot((u - cu) / fu, (v - cv) / fv) for u in (0, 639) for v in (0, 479))
    assert 0.9 * fold < corner < 1.001 * fold  # the zooms that are tried are 0.0004 apart
    assert "leaves out" in undistorter.words


def test_a_lens_that_sees_behind_itself_keeps_what_a_plane_can_hold():
    from polhode_ground.importing.lens import lens_of
    from polhode_ground.importing.undistorting import Undistorter
    fu, fv, _, _ = Undistorter(lens_of(1000, 1000, (250, 250, 499.5, 499.5), "equidistant", (), "file"), "file").lens.intrinsics_px
    assert 2 * np.degrees(np.arctan(499.5 / fu)) == pytest.approx(118, abs=0.5) and fu == pytest.approx(fv)


def test_a_region_far_from_the_axis_is_undistorted_where_it_is():
    from polhode_ground.importing.lens import lens_of
    from polhode_ground.importing.undistorting import Undistorter
    lens = lens_of(640, 480, (900, 900, -300, 700), "", (-0.1, 0.01, 0, 0, 0.02), "file")
    fu, fv, cu, cv = Undistorter(lens, "file").lens.intrinsics_px
    middle = lens.project(np.array([[(319.5 - cu) / fu, (239.5 - cv) / fv, 1]]))[0]
    assert np.abs(middle - (319.5, 239.5)).max() < 5  # the new picture's middle shows the old one's
