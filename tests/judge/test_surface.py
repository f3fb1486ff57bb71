"""The surface that follows the cloud: through what was measured, closed by the hull where nothing was seen, marked there."""

import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY
from polhode_ground.judge.shape import load_ply, property_of
from polhode_ground.reporting import surface
from polhode_ground.testing.synthetic import BOX_M, Errors, box_points, tumbling_body, write_run
from scipy.spatial import ConvexHull, cKDTree

NEEDS_COLMAP = pytest.mark.skipif(not (REPOSITORY / ".venv-colmap/bin/python3").exists(), reason="pycolmap is not installed: tools/setup.sh colmap")


def box_surface(low, high, count, seed):
    """(points [N,3], outward normals [N,3]) on a box, as many an area everywhere."""
    random, size = np.random.default_rng(seed), np.subtract(high, low)
    area = np.prod(size) / size
    axis = random.choice(3, size=count, p=area / area.sum())
    side = random.choice([0, 1], size=count)
    points, normals, rows = random.uniform(low, high, (count, 3)), np.zeros((count, 3)), np.arange(count)
    points[rows, axis] = np.where(side, np.take(high, axis), np.take(low, axis))
    normals[rows, axis] = 2 * side - 1
    return points, normals


def stairs():
    """Points and normals of a step, 1 x 1 x 1 with a notch of 0.5 x 1 x 0.5 cut out where x and z are positive. Its bottom was not seen."""
    low, low_normals = box_surface((-0.5, -0.5, -0.5), (0.5, 0.5, 0.0), 3000, 1)
    high, high_normals = box_surface((-0.5, -0.5, 0.0), (0.0, 0.5, 0.5), 2000, 2)
    keep_low = ~(np.isclose(low[:, 2], 0.0) & (low[:, 0] < 0)) & (low[:, 2] > -0.499)
    keep_high = ~np.isclose(high[:, 2], 0.0)
    return np.concatenate([low[keep_low], high[keep_high]]), np.concatenate([low_normals[keep_low], high_normals[keep_high]])


def sights_out_of_the_notch(points):
    seen = points[(points[:, 0] > 0.1) & (np.abs(points[:, 2]) < 1e-9) | (np.abs(points[:, 0]) < 1e-9) & (points[:, 2] > 0.1)]
    return seen, np.tile([3.0, 0.0, 3.0], (len(seen), 1))


def test_the_hull_closes_what_was_not_seen_and_nothing_that_was_seen_through():
    points, normals = stairs()
    hull, pitch = ConvexHull(points), surface.pitch_of(points)
    assert pitch == pytest.approx(np.sqrt(4.75 / len(points)), rel=0.2)  # the step's area is 6 less a bottom of 1 and a quarter of either end
    def over_notch(found):
        return (found[:, 0] > 0.1) & (found[:, 2] > 0.1) & (np.abs(found[:, 1]) < 0.4)

    blind, _ = surface.unseen_sides(hull, points, (np.empty((0, 3)), np.empty((0, 3))), pitch)
    assert over_notch(blind).sum() > 50  # the hull's slope over the notch
    sides, side_normals = surface.unseen_sides(hull, points, sights_out_of_the_notch(points), pitch)
    assert over_notch(sides).sum() < 0.1 * over_notch(blind).sum()
    bottom = sides[:, 2] < -0.45
    assert bottom.sum() > 100 and (side_normals[bottom, 2] < -0.9).all()


def test_what_sticks_out_of_the_hull_is_moved_onto_it():
    hull = ConvexHull(box_points(400))
    inside, outside = np.array([[0.1, 0.0, 0.2]]), np.array([[0.5, 0.0, 0.0], [0.5, 0.5, 0.9]])
    assert np.allclose(surface.within(hull, inside), inside)
    moved = surface.within(hull, outside)
    assert (np.abs(moved) <= BOX_M / 2 + 1e-3).all() and np.allclose(moved[0], [BOX_M[0] / 2, 0, 0], atol=0.02)


@pytest.mark.further
@NEEDS_COLMAP
def test_it_follows_a_notch_that_a_hull_closes():
    points, normals = stairs()
    hull, pitch = ConvexHull(points), surface.pitch_of(points)
    sides, side_normals = surface.unseen_sides(hull, points, sights_out_of_the_notch(points), pitch)
    vertices, faces = surface.without_islands(*surface.reconstruct(np.concatenate([points, sides]), np.concatenate([normals, side_normals]), pitch))
    # The hull's slope over the notch is 0.35 from its inner edge. Poisson rounds edges by a cell of the octree, which is two pitches or more.
    assert cKDTree(vertices).query([[0.0, 0.0, 0.0], [0.02, 0.3, 0.02]])[0].max() < 4 * pitch < 0.15
    assert np.quantile(cKDTree(points).query(vertices[vertices[:, 2] > -0.3])[0], 0.95) < 2 * pitch


def made_run(folder: pathlib.Path, scale: float = 1.0) -> pathlib.Path:
    """A run on the box whose bottom was not seen."""
    errors = Errors(scale=scale)
    run = write_run(folder, tumbling_body(frames=12), errors)
    points, normals = box_surface(-BOX_M / 2, BOX_M / 2, 1500, 4)
    seen = points[:, 2] > -0.499 * BOX_M[2]
    places, turned = scale * (errors.R_ET.apply(points[seen]) + errors.offset_E_m), errors.R_ET.apply(normals[seen])
    rows = np.zeros(len(places), dtype=[("place", "<f4", 3), ("normal", "<f4", 3), ("added", "u1")])
    rows["place"], rows["normal"] = places, turned
    names = [*(f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")), "property uchar added"]
    (run / "cloud.ply").write_bytes("\n".join(["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}", *names, "end_header", ""]).encode()
                                    + rows.tobytes())
    marks = scale * (errors.R_ET.apply(box_points(60)) + errors.offset_E_m)
    header = ["ply", "format ascii 1.0", "element vertex 60", *(f"property float {name}" for name in "xyz"), "property int landmark", "end_header"]
    (run / "cloud_raw.ply").write_text("\n".join([*header, *(" ".join(map(str, [*place, number])) for number, place in enumerate(marks))]) + "\n")
    return run


def call(*arguments):
    return subprocess.run([sys.executable, REPOSITORY / "tools/surface.py", *map(str, arguments)], capture_output=True, text=True)


def test_lines_of_sight_end_at_the_camera(tmp_path):
    from polhode_ground.common.tables import read_motion
    from polhode_ground.judge import align
    run = made_run(tmp_path / "run")
    from_T, to_T = surface.lines_of_sight(run)
    assert len(from_T) == 12 * 54  # six of 60 observations a frame are outliers
    motion = read_motion(run / "motion_smoothed.csv")
    # Seen from the first camera, its landmarks are where observations.csv predicts them.
    p_C = align.rotations(motion.q_CT[[0]])[0].apply(to_T[0]) + motion.p_CT[0]
    assert np.allclose(p_C, 0, atol=1e-9)


@pytest.mark.further
@NEEDS_COLMAP
@pytest.mark.parametrize("scale", [1.0, 0.03])
def test_the_unseen_side_is_marked(tmp_path, scale):
    run, errors = made_run(tmp_path / "run", scale), Errors(scale=scale)
    done = call(run)
    assert done.returncode == 0 and "faces," in done.stdout, done.stderr
    mesh = load_ply(run / "surface.ply")
    vertices = errors.R_ET.inv().apply(np.asarray(mesh.vertices) / scale - errors.offset_E_m)
    added = property_of(mesh, "added", len(vertices)) > 0
    assert b"Poisson" in (run / "surface.ply").read_bytes()[:200]
    bottom = vertices[:, 2] < -0.47 * BOX_M[2]
    inner = (np.abs(vertices[:, :2]) < 0.2 * BOX_M[:2]).all(axis=1)  # farther from the sides than a measured point reaches
    assert added[bottom & inner].all() and (bottom & inner).sum() > 5
    assert added[vertices[:, 2] > -0.3 * BOX_M[2]].mean() < 0.02
    assert np.abs(vertices).max(axis=0) == pytest.approx(BOX_M / 2, abs=0.03)
    again = (run / "surface.ply").read_bytes()
    assert call(run).returncode == 0 and (run / "surface.ply").read_bytes() == again


@pytest.mark.parametrize(("spoil", "says"), [
    (lambda run: shutil.rmtree(run), "run/cloud.ply: not there"),
    (lambda run: (run / "cloud.ply").write_text("no ply"), "cloud.ply: not a readable PLY file"),
    (lambda run: (run / "cloud.ply").write_text("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n"),
     "cloud.ply: 0 points, at least 100 are needed"),
    (lambda run: (run / "cloud.ply").write_text((run / "cloud_raw.ply").read_text()), "holds no normals"),
    (lambda run: (run / "cloud_raw.ply").unlink(), "cloud_raw.ply")])
def test_what_holds_no_cloud_is_refused(tmp_path, spoil, says):
    run = made_run(tmp_path / "run")
    spoil(run)
    done = call(run)
    assert done.returncode == 2 and says in done.stderr.splitlines()[-1] and done.stderr.count("\n") == 1, done.stderr
    assert not (run / "surface.ply").exists()


def test_points_in_a_plane_enclose_nothing(tmp_path):
    run = made_run(tmp_path / "run")
    points = np.random.default_rng(1).uniform(-1, 1, (200, 3)) * [1, 1, 0]
    header = ["ply", "format ascii 1.0", "element vertex 200", *(f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")),
              "property uchar added", "end_header"]
    (run / "cloud.ply").write_text("\n".join([*header, *(" ".join(map(str, [*point, 0, 0, 1, 0])) for point in points)]) + "\n")
    with pytest.raises(BadInput, match="enclose no volume"):
        surface.make_surface(run)
