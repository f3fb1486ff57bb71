"""What shape.json and surface.ply say of the body, against the true mesh: planes, cylinder, centroid, lengths, hull.

Everything is compared in the truth's body frame after the trajectory's alignment, so a wrong scale or attitude of the
whole run is not counted a second time here.
"""

import json
import pathlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.spatial import ConvexHull, QhullError

from polhode_ground.common.errors import BadInput
from polhode_ground.judge.align import axis_angle_deg
from polhode_ground.judge.aligned import Aligned
from polhode_ground.judge.shape import (
    SURFACE_SAMPLES,
    cloud_in_truth,
    load_ply,
    nearest_m,
    property_of,
    read_cloud,
    sample_mesh,
    seen_samples,
)

# The mesh belongs to a found side where it runs this near, in parts of the body's size, and this parallel.
NEAR_SIZES = 0.025
PARALLEL_MIN = np.cos(np.radians(20.0))
# A side that the mesh fills by less than this is made up: there is no such side.
FILLED_MIN = 0.25
GRID = 8
# So many of the mesh's samples, a hundredth of them, make a side; this percentile of them is its outermost part.
SIDE_SAMPLES_MIN = SURFACE_SAMPLES // 100
OUTERMOST_PERCENT = 95
# Samples of one side have no wider gap between them along its normal.
GAP_SIZES = 0.005
# The round part of the mesh, around the cylinder that was found.
NEAR_RADII = 0.15
RADIAL_MIN = np.cos(np.radians(30.0))
HULL_SAMPLES = 20_000
# Their spacing on a body is 0.3 % of its size, as fine as clouds are exact.
FACE_SAMPLES = 100_000


class Truth:
    """The mesh as samples in its body frame, and the way of the estimate's vectors there."""

    def __init__(self, model_path: pathlib.Path, aligned: Aligned, scene: dict[str, Any]):
        self.points_T, self.normals_T, self.size_m = sample_mesh(model_path)
        self.aligned, self.scene = aligned, scene

    def point(self, point_E: ArrayLike) -> np.ndarray:
        return np.asarray(cloud_in_truth(np.asarray(point_E, dtype=float)[None, :], self.aligned)[0])

    def direction(self, direction_E: ArrayLike) -> np.ndarray:
        return self.aligned.R_ET.inv().apply(np.asarray(direction_E, dtype=float))

    def length_m(self, length: float) -> float:
        return float(self.aligned.similarity.scale) * length

    @property
    def centre_T(self) -> np.ndarray:
        """Geometric centre of the whole body: what a torn side would have reached counts, too."""
        scene = self.scene.get("scene", {})
        if scene.get("target", {}).get("kind") == "damaged_cube":
            return -np.asarray(scene["motion"]["centre_of_mass_G_m"], dtype=float)
        return np.asarray(0.5 * (self.points_T.min(axis=0) + self.points_T.max(axis=0)))


def judge_plane(plane: dict[str, Any], truth: Truth) -> dict[str, Any]:
    """Angle and distance of one side from the mesh's own surface there; made_up where the mesh has none."""
    normal = truth.direction(plane["normal_T"])
    centre = truth.point(plane["centre_T"])
    axes = np.array([truth.direction(axis) for axis in plane["extent_axes_T"]])
    half_m = 0.5 * np.array([truth.length_m(length) for length in plane["extents"]])
    off = (truth.points_T - centre) @ normal
    along = (truth.points_T - centre) @ axes.T
    near = (
        (np.abs(off) < NEAR_SIZES * truth.size_m)
        & np.all(np.abs(along) <= half_m, axis=1)
        & (np.abs(truth.normals_T @ normal) > PARALLEL_MIN)
    )
    cells = np.unique(np.floor((along[near] / half_m * 0.5 + 0.5).clip(0, 0.999) * GRID).astype(int) @ [1, GRID])
    filled = len(cells) / GRID**2
    result = {"inliers": plane["inliers"], "filled_by_mesh": filled, "made_up": bool(filled < FILLED_MIN)}
    if result["made_up"]:
        return result
    turned = truth.normals_T[near] * np.sign(truth.normals_T[near] @ normal)[:, None]
    mean = turned.mean(axis=0)
    return result | {
        "angle_deg": axis_angle_deg(normal, mean),
        "distance_m": float(np.median(off[near])),
        "sigma_angle_deg": float(np.degrees(plane.get("sigma_normal_rad", np.nan))),
    }


def _true_cylinder(
    points_T: np.ndarray, normals_T: np.ndarray, axis: np.ndarray, centre: np.ndarray, radius: float, length: float
) -> tuple[np.ndarray, float] | None:
    """(axis, radius) of the mesh's round part around a guess; None where it has none."""

    def parts(axis: np.ndarray, centre: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        apart = points - centre
        height = apart @ axis
        return apart - height[:, None] * axis, height

    radial, height = parts(axis, centre, points_T)
    distance = np.linalg.norm(radial, axis=1)
    facing = np.abs(np.einsum("ij,ij->i", radial, normals_T)) >= RADIAL_MIN * distance
    near = (np.abs(distance - radius) < NEAR_RADII * radius) & (np.abs(height) < 0.45 * length) & facing
    if near.sum() < 500:
        return None
    points = points_T[near][:: max(1, near.sum() // 5000)]
    e1 = np.linalg.svd(axis[None, :])[2][1]
    e2 = np.cross(axis, e1)

    def unpack(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        turned = axis + x[0] * e1 + x[1] * e2
        return turned / np.linalg.norm(turned), centre + x[2] * e1 + x[3] * e2, x[4]

    def residual(x: np.ndarray) -> np.ndarray:
        turned, moved, r = unpack(x)
        return np.asarray(np.linalg.norm(parts(turned, moved, points)[0], axis=1) - r)

    fit = least_squares(residual, [0, 0, 0, 0, radius], loss="soft_l1", f_scale=0.01 * radius)
    turned, _, true_radius = unpack(fit.x)
    return turned, float(true_radius)


def judge_cylinder(cylinder: dict[str, Any], truth: Truth) -> dict[str, Any]:
    axis, centre = truth.direction(cylinder["axis_T"]), truth.point(cylinder["centre_T"])
    radius_m = truth.length_m(cylinder["radius"])
    found = _true_cylinder(truth.points_T, truth.normals_T, axis, centre, radius_m, truth.length_m(cylinder["length"]))
    if found is None:
        return {"made_up": True}
    true_axis, true_radius_m = found
    return {
        "made_up": False,
        "axis_error_deg": axis_angle_deg(axis, true_axis),
        "sigma_axis_deg": float(np.degrees(cylinder.get("sigma_axis_rad", np.nan))),
        "radius_error_percent": 100 * (radius_m / true_radius_m - 1),
        "sigma_radius_percent": 100 * cylinder.get("sigma_radius", np.nan) / cylinder["radius"],
    }


def judge_centroid(shape: dict[str, Any], truth: Truth) -> dict[str, Any]:
    before, after = (float(np.linalg.norm(truth.point(shape[key]) - truth.centre_T)) for key in ("centroid_of_measured_T", "centroid_T"))
    return {
        "error_before_completion_percent": 100 * before / truth.size_m,
        "error_percent": 100 * after / truth.size_m,
        "nearer_by": before / after if after > 0 else None,
    }


def _side_m(truth: Truth, outward: np.ndarray, at_m: float) -> float | None:
    """How far out the mesh has a side that faces along `outward`, near a place; None where it has none.

    Of a flat side all samples agree; a round one reaches as far as its outermost, which may lie farther out than a place
    that was found wrong: what goes on without a gap belongs to it.
    """
    facing = np.sort((truth.points_T @ outward)[truth.normals_T @ outward > PARALLEL_MIN])
    begin, end = np.searchsorted(facing, [at_m - NEAR_SIZES * truth.size_m, at_m + NEAR_SIZES * truth.size_m])
    if end - begin < SIDE_SAMPLES_MIN:
        return None
    gaps = np.flatnonzero(np.diff(facing[end - 1 :]) > GAP_SIZES * truth.size_m)
    end += int(gaps[0]) if len(gaps) else len(facing) - end
    return float(np.percentile(facing[begin:end], OUTERMOST_PERCENT))


def _true_length_m(shape: dict[str, Any], truth: Truth, axis: np.ndarray, found_m: float, rests_on: str | None) -> float:
    """Between the mesh's own sides where the length claims to rest on surfaces, else the mesh's extent.

    What stands out of a side, an antenna or a torn edge, is no part of a length between surfaces.
    """
    if rests_on == "surfaces":
        middle_m = truth.point(shape["centroid_T"]) @ axis
        low, high = (_side_m(truth, sign * axis, sign * middle_m + 0.5 * found_m) for sign in (-1, 1))
        if low is not None and high is not None and low + high > 0.0:
            return low + high
    return float(np.ptp(truth.points_T @ axis))


def judge_dimensions(shape: dict[str, Any], truth: Truth) -> list[dict[str, Any]]:
    """Lengths along the found axes. One that does not rest on surfaces says "at least": it is off only where it is too long."""
    result = []
    for k, name in enumerate("xyz"):
        rests_on = shape.get("dimensions_rest_on", [None] * 3)[k]
        axis, found_m = truth.direction(shape["axes"][name]), truth.length_m(shape["dimensions"][k])
        true_m = _true_length_m(shape, truth, axis, found_m, rests_on)
        sigma_m = truth.length_m(shape["sigma_dimensions"][k])
        off_m = max(0.0, found_m - true_m) if rests_on in ("points", "nothing") else abs(found_m - true_m)
        result.append(
            {
                "axis": name,
                "true_m": true_m,
                "found_m": found_m,
                "error_percent": 100 * (found_m / true_m - 1),
                "sigmas_off": off_m / sigma_m if sigma_m > 0 else None,
                "rests_on": rests_on,
            }
        )
    return result


def judge_surface(path: pathlib.Path, truth: Truth) -> dict[str, Any] | None:
    """The coarse surface against the convex hull of the mesh; None where it holds no volume."""
    import trimesh

    corners_E = read_cloud(path)
    if len(corners_E) < 4:
        return None
    try:
        found = ConvexHull(cloud_in_truth(corners_E, truth.aligned))
        true = ConvexHull(truth.points_T)
    except QhullError:
        return None

    def samples(hull: ConvexHull) -> np.ndarray:
        mesh = trimesh.Trimesh(hull.points, hull.simplices, process=False)
        return np.asarray(trimesh.sample.sample_surface(mesh, HULL_SAMPLES, seed=1)[0])

    found_points, true_points = samples(found), samples(true)
    outward, inward = nearest_m(found_points, true_points), nearest_m(true_points, found_points)
    # The spacing of the samples is left in: about 0.4 % of the size.
    return {
        "volume_error_percent": 100 * (found.volume / true.volume - 1),
        "distance_rmse_percent": 100 * float(np.sqrt(np.mean(outward**2))) / truth.size_m,
        "complete_within_5_percent": float(np.mean(inward <= 0.05 * truth.size_m)),
    }


def judge_faces(path: pathlib.Path, truth: Truth) -> dict[str, Any] | None:
    """A surface's measured faces against the mesh, and how near what was seen of the mesh is to any face; None where it has no faces."""
    import trimesh

    found = load_ply(path)
    if len(getattr(found, "faces", ())) == 0:
        return None
    added = property_of(found, "added", len(found.vertices))
    measured = np.ones(len(found.faces), bool) if added is None else ~(added[found.faces] > 0).any(axis=1)
    vertices_T = cloud_in_truth(np.asarray(found.vertices, dtype=float), truth.aligned)

    def samples(faces: np.ndarray) -> np.ndarray:
        return np.asarray(trimesh.sample.sample_surface(trimesh.Trimesh(vertices_T, faces, process=False), FACE_SAMPLES, seed=1)[0])

    result: dict[str, Any] = {"faces": len(found.faces), "measured_rmse_percent": None, "seen_rmse_percent": None}
    if measured.any():
        result["measured_rmse_percent"] = (
            100 * float(np.sqrt(np.mean(nearest_m(samples(found.faces[measured]), truth.points_T) ** 2))) / truth.size_m
        )
    seen = seen_samples(truth.points_T, truth.normals_T, truth.aligned.R_CT, truth.aligned.truth.p_CT[truth.aligned.rows_T])
    if seen.any():
        result["seen_rmse_percent"] = (
            100 * float(np.sqrt(np.mean(nearest_m(truth.points_T[seen], samples(found.faces)) ** 2))) / truth.size_m
        )
    return result


def judge_body(folder: pathlib.Path, model_path: pathlib.Path, scene: dict[str, Any], aligned: Aligned) -> dict[str, Any] | None:
    """All of the above; None where there is no shape.json or no mesh."""
    path = folder / "shape.json"
    if not path.exists() or not model_path.exists():
        return None
    try:
        report = json.loads(path.read_text())
    except (OSError, ValueError) as problem:
        raise BadInput(f"{path}: not readable JSON ({problem})") from None
    shape = report.get("shape")
    if shape is None:
        return {"found": False, "reason": report.get("reason")}
    truth = Truth(model_path, aligned, scene)
    planes = [judge_plane(plane, truth) for plane in shape["planes"]]
    angles = [plane["angle_deg"] for plane in planes if not plane["made_up"]]
    surface = folder / "surface.ply"
    return {
        "found": True,
        "planes": planes,
        "planes_found": len(planes),
        "planes_made_up": sum(plane["made_up"] for plane in planes),
        "plane_angle_max_deg": max(angles) if angles else None,
        "plane_angle_median_deg": float(np.median(angles)) if angles else None,
        "cylinder": judge_cylinder(shape["cylinder"], truth) if shape["cylinder"] else None,
        "centroid": judge_centroid(shape, truth),
        "dimensions": judge_dimensions(shape, truth),
        "surface": judge_surface(surface, truth) if surface.exists() else None,
        "faces": judge_faces(surface, truth) if surface.exists() else None,
        "scale_contradiction": report.get("scale", {}).get("contradiction"),
    }
