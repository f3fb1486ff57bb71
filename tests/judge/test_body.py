"""The judge of shape.json and surface.ply on made-up bodies: what goes in as an error comes out as that number."""

import json

import numpy as np
import pytest
from polhode_ground.common.sequence import read_sequence
from polhode_ground.judge.body import judge_body
from polhode_ground.judge.run import best_alignment, read_run, read_truth
from polhode_ground.judge.shape import read_cloud
from polhode_ground.testing.synthetic import BOX_M, Errors, tumbling_body, write_ply, write_run, write_sequence
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="module")
def body():
    return tumbling_body()


@pytest.fixture(scope="module")
def scene(tmp_path_factory, body):
    return write_sequence(tmp_path_factory.mktemp("scene") / "seq", body)


class Estimate:
    """A run whose shape.json is the truth's box in the run's own body frame, to be made wrong by the tests."""

    def __init__(self, folder, body, scene, errors=None):
        self.errors = errors or Errors()
        self.run = read_run(write_run(folder / "run", body, self.errors))
        self.sequence = read_sequence(scene)
        self.shape = {
            "centroid_T": self.point([0, 0, 0]), "centroid_of_measured_T": self.point([0.1, 0, 0]),
            "axes": {axis: self.direction(np.eye(3)[k]) for k, axis in enumerate("xyz")},
            "dimensions": [self.errors.scale * length for length in BOX_M],
            "sigma_dimensions": [self.errors.scale * 0.01] * 3, "dimensions_rest_on": ["surfaces"] * 3,
            "planes": [self.plane(k) for k in range(3)], "cylinder": None}

    def point(self, point_T):
        return list(self.errors.scale * (self.errors.R_ET.apply(point_T) + self.errors.offset_E_m))

    def direction(self, direction_T):
        return list(self.errors.R_ET.apply(direction_T))

    def plane(self, axis, tilt_deg=0.0, out_m=0.0):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        turn = Rotation.from_rotvec(np.radians(tilt_deg) * u)
        normal, v = turn.apply(np.eye(3)[axis]), turn.apply(v)
        return {"normal_T": self.direction(normal), "centre_T": self.point(np.eye(3)[axis] * (BOX_M[axis] / 2 + out_m)),
                "extents": [self.errors.scale * BOX_M[(axis + k) % 3] for k in (1, 2)],
                "extent_axes_T": [self.direction(u), self.direction(v)], "inliers": 100, "sigma_normal_rad": 0.01}

    def judged(self):
        (self.run.folder / "shape.json").write_text(json.dumps({"shape": self.shape}))
        aligned = best_alignment(self.run, read_truth(self.sequence))
        return judge_body(self.run.folder, self.sequence.model_path, {}, aligned)


def test_a_right_box_has_no_errors_in_any_frame_and_unit(tmp_path, scene, body):
    report = Estimate(tmp_path, body, scene, Errors(scale=0.2, scale_known=False)).judged()
    assert report["planes_found"] == 3 and report["planes_made_up"] == 0
    assert report["plane_angle_max_deg"] < 0.01
    assert max(abs(plane["distance_m"]) for plane in report["planes"]) < 1e-4
    assert report["centroid"]["error_percent"] < 0.05
    # The samples end a little before the edges.
    assert max(abs(length["error_percent"]) for length in report["dimensions"]) < 0.1
    assert report["cylinder"] is None and report["surface"] is None


def test_a_tilted_side_is_off_by_its_tilt_and_a_moved_one_by_its_way(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    estimate.shape["planes"] = [estimate.plane(0, tilt_deg=1.5), estimate.plane(1, out_m=0.01)]
    planes = estimate.judged()["planes"]
    assert planes[0]["angle_deg"] == pytest.approx(1.5, abs=0.02)
    assert planes[1]["distance_m"] == pytest.approx(-0.01, abs=1e-4)


def test_a_side_through_the_inside_is_made_up(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    estimate.shape["planes"].append(estimate.plane(2, out_m=-BOX_M[2] / 2))
    report = estimate.judged()
    assert report["planes_made_up"] == 1 and report["planes"][3]["made_up"]


def test_a_centroid_is_judged_before_and_after_completion(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    estimate.shape["centroid_T"] = estimate.point([0.0, 0.02, 0.0])
    centroid = estimate.judged()["centroid"]
    size = np.linalg.norm(BOX_M)
    assert centroid["error_percent"] == pytest.approx(100 * 0.02 / size, rel=0.01)
    assert centroid["error_before_completion_percent"] == pytest.approx(100 * 0.1 / size, rel=0.01)
    assert centroid["nearer_by"] == pytest.approx(5.0, rel=0.02)


def test_a_wrong_length_shows_in_percent_and_sigmas(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    estimate.shape["dimensions"][0] += 0.03
    length = estimate.judged()["dimensions"][0]
    assert length["error_percent"] == pytest.approx(100 * 0.03 / BOX_M[0], abs=0.1)
    assert length["sigmas_off"] == pytest.approx(3.0, abs=0.1)


def test_a_length_that_ends_where_points_do_says_at_least(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    estimate.shape["dimensions_rest_on"] = ["points", "points", "surfaces"]
    estimate.shape["dimensions"] = [length + change for length, change in zip(BOX_M, (-0.1, 0.03, -0.03))]
    assert [length["sigmas_off"] for length in estimate.judged()["dimensions"]] == pytest.approx([0.0, 3.0, 3.0], abs=0.1)


def test_a_diameter_is_judged_by_the_round_sides_outermost(tmp_path, body):
    import trimesh
    scene = write_sequence(tmp_path / "seq", body)
    tube = trimesh.creation.cylinder(radius=0.3, height=1.2, sections=128)
    write_ply(scene / "model.ply", tube.vertices, tube.faces)
    estimate = Estimate(tmp_path, body, scene)
    for wrong in (0.62, 0.54, 0.52):
        estimate.shape["dimensions"] = [0.6, wrong, 1.2]
        lengths = estimate.judged()["dimensions"]
        assert [length["true_m"] for length in lengths] == pytest.approx([0.6, 0.6, 1.2], abs=3e-3)


def test_a_length_of_almost_nothing_is_judged_all_the_same(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    estimate.shape["dimensions"][0] = 0.001
    assert estimate.judged()["dimensions"][0]["true_m"] == pytest.approx(BOX_M[0], abs=1e-3)


def test_what_stands_out_of_a_side_is_no_part_of_the_length_between_sides(tmp_path, body):
    import trimesh
    scene = write_sequence(tmp_path / "seq", body)
    mast = trimesh.creation.box(extents=(0.02, 0.02, 0.3), transform=trimesh.transformations.translation_matrix((0, 0, BOX_M[2] / 2)))
    both = trimesh.util.concatenate([trimesh.creation.box(extents=BOX_M), mast])
    write_ply(scene / "model.ply", both.vertices, both.faces)
    estimate = Estimate(tmp_path, body, scene)
    between = estimate.judged()["dimensions"][2]
    assert between["true_m"] == pytest.approx(BOX_M[2], abs=2e-3)
    estimate.shape["dimensions_rest_on"][2] = "points"
    assert estimate.judged()["dimensions"][2]["true_m"] == pytest.approx(BOX_M[2] + 0.15, abs=2e-3)


def test_the_hull_of_the_corners_is_the_bodys(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * BOX_M
    write_ply(estimate.run.folder / "surface.ply", np.array([estimate.point(corner) for corner in 1.1 * corners]))
    surface = estimate.judged()["surface"]
    assert surface["volume_error_percent"] == pytest.approx(100 * (1.1**3 - 1), abs=0.5)
    # Sides stand out by 5 % of the box's lengths, 3 cm in the mean of the squares; the samples' spacing adds a little.
    assert 100 * 0.02 / np.linalg.norm(BOX_M) < surface["distance_rmse_percent"] < 100 * 0.05 / np.linalg.norm(BOX_M)
    write_ply(estimate.run.folder / "surface.ply", np.zeros((0, 3)))
    assert estimate.judged()["surface"] is None


def test_faces_are_judged_by_what_they_measured_and_by_what_was_seen(tmp_path, scene, body):
    import trimesh
    estimate = Estimate(tmp_path, body, scene)
    path = estimate.run.folder / "surface.ply"
    box = trimesh.creation.box(extents=BOX_M).subdivide().subdivide()

    def judged(vertices_T, added):
        vertices = np.array([estimate.point(vertex) for vertex in vertices_T])
        rows = [" ".join(map(str, [*vertex, int(mark)])) for vertex, mark in zip(vertices, added)]
        header = ["ply", "format ascii 1.0", f"element vertex {len(rows)}", *(f"property float {a}" for a in "xyz"), "property uchar added",
                  f"element face {len(box.faces)}", "property list uchar int vertex_indices", "end_header"]
        path.write_text("\n".join([*header, *rows, *(f"3 {a} {b} {c}" for a, b, c in box.faces)]) + "\n")
        return estimate.judged()["faces"]
    size_m, none = np.linalg.norm(BOX_M), np.zeros(len(box.vertices), bool)
    exact = judged(box.vertices, none)
    assert exact["measured_rmse_percent"] < 0.3 and exact["seen_rmse_percent"] < 0.5  # spacing of the samples
    # A dent of 0.1 m in the upper side. Where it is marked as not measured, it is no error of what was measured, but of what was seen.
    top = np.isclose(box.vertices[:, 2], BOX_M[2] / 2) & (np.abs(box.vertices[:, :2]) < 0.3 * np.array(BOX_M[:2])).all(axis=1)
    dented = box.vertices - 0.1 * np.outer(top, [0, 0, 1])
    assert top.any()
    wrong, marked = judged(dented, none), judged(dented, top)
    assert wrong["measured_rmse_percent"] > 100 * 0.02 / size_m
    assert marked["measured_rmse_percent"] == pytest.approx(exact["measured_rmse_percent"], abs=0.1)
    # From the true side the nearest place of the dent is on its slope, not at its bottom.
    assert marked["seen_rmse_percent"] == pytest.approx(wrong["seen_rmse_percent"], abs=0.05) and marked["seen_rmse_percent"] > 100 * 0.01 / size_m
    write_ply(path, box.vertices)
    assert estimate.judged()["faces"] is None


def test_no_shape_is_a_report_with_its_reason(tmp_path, scene, body):
    estimate = Estimate(tmp_path, body, scene)
    (estimate.run.folder / "shape.json").write_text(json.dumps({"shape": None, "reason": "there is no map"}))
    aligned = best_alignment(estimate.run, read_truth(estimate.sequence))
    report = judge_body(estimate.run.folder, estimate.sequence.model_path, {}, aligned)
    assert report == {"found": False, "reason": "there is no map"}


def test_a_round_body_is_judged_by_its_axis_and_radius(tmp_path, body):
    import trimesh
    scene = write_sequence(tmp_path / "seq", body)
    tube = trimesh.creation.cylinder(radius=0.3, height=1.2, sections=128)
    write_ply(scene / "model.ply", tube.vertices, tube.faces)
    estimate = Estimate(tmp_path, body, scene)
    axis = Rotation.from_rotvec([np.radians(0.7), 0, 0]).apply([0, 0, 1])
    estimate.shape["cylinder"] = {"axis_T": estimate.direction(axis), "centre_T": estimate.point([0, 0, 0]),
                                  "radius": 0.306, "length": 1.2, "sigma_radius": 0.003, "sigma_axis_rad": 0.01}
    found = estimate.judged()["cylinder"]
    assert found["axis_error_deg"] == pytest.approx(0.7, abs=0.05)
    assert found["radius_error_percent"] == pytest.approx(2.0, abs=0.15)
    estimate.shape["cylinder"]["radius"] = 0.15
    assert estimate.judged()["cylinder"]["made_up"]


def test_points_that_completion_added_are_not_judged_as_measured(tmp_path):
    header = ["ply", "format ascii 1.0", "element vertex 3", *(f"property float {a}" for a in "xyz"), "property uchar added",
              "end_header"]
    marked = tmp_path / "cloud.ply"
    marked.write_text("\n".join([*header, "0 0 0 0", "1 0 0 1", "2 0 0 0"]) + "\n")
    assert read_cloud(marked, measured_only=True)[:, 0].tolist() == [0.0, 2.0]
    assert len(read_cloud(marked)) == 3
    write_ply(tmp_path / "plain.ply", np.eye(3))
    assert len(read_cloud(tmp_path / "plain.ply", measured_only=True)) == 3
