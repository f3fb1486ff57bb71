"""Distance of an estimated cloud to the true mesh, and how much of what was seen it covers."""

import pathlib
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from polhode_ground.common.errors import BadInput
from polhode_ground.judge.aligned import Aligned

# Spacing of samples is about size * sqrt(area factor / count): 0.2 % of the size for a box, well under what is judged.
SURFACE_SAMPLES = 200_000
# A place of the surface counts as covered when a cloud point is this near, in % of the body's size.
COVERED_PERCENT = (2.0, 5.0)
# Cells across a set of points within which they are kept together: a tree answers neighbours four times as fast as points at random.
SORTING_CELLS = 16
# Views that decide what was seen, spread over the run, and the grid of their depth test in cells across the body.
VIEWS = 40
DEPTH_CELLS = 220


def load_ply(path: pathlib.Path) -> Any:
    import trimesh

    try:
        return trimesh.load(path, process=False)
    except Exception as problem:  # the reader's own errors have no common base class
        raise BadInput(f"{path}: not a readable PLY file ({problem})") from None


def read_cloud(path: pathlib.Path, measured_only: bool = False) -> np.ndarray:
    """Points [N,3] of a PLY file; with measured_only those that completion added, where they are marked, are left out."""
    mesh = load_ply(path)
    points = np.asarray(getattr(mesh, "vertices", np.empty((0, 3))), dtype=float)
    if len(points) == 0:
        return points.reshape(0, 3)
    keep = np.isfinite(points).all(axis=1)
    if measured_only:
        added = property_of(mesh, "added", len(points))
        keep &= added == 0 if added is not None else True
    return np.asarray(points[keep])


def read_landmark_numbers(path: pathlib.Path) -> set[int] | None:
    """Numbers of the landmarks in a cloud_raw.ply; None where it does not give them."""
    mesh = load_ply(path)
    numbers = property_of(mesh, "landmark", len(getattr(mesh, "vertices", ())))
    return None if numbers is None else set(numbers.tolist())


def property_of(mesh: Any, name: str, count: int) -> np.ndarray | None:
    """A property of each point [N] of a PLY file; None where the file has none of that name."""
    try:
        values = np.asarray(mesh.metadata["_ply_raw"]["vertex"]["data"][name]).reshape(-1)
    except (AttributeError, KeyError, IndexError, TypeError, ValueError):
        return None
    return values if len(values) == count else None


def sample_mesh(path: pathlib.Path) -> tuple[np.ndarray, np.ndarray, float]:
    """(points [S,3], outward normals [S,3], size) of a mesh; size is its bounding box's diagonal [m]."""
    import trimesh

    mesh = load_ply(path)
    if isinstance(mesh, trimesh.Scene):
        mesh = mesh.to_mesh()
    if getattr(mesh, "faces", None) is None or len(mesh.faces) == 0:
        raise BadInput(f"{path}: holds no faces, a mesh is needed")
    points, faces = trimesh.sample.sample_surface(mesh, SURFACE_SAMPLES, seed=1)
    return np.asarray(points), np.asarray(mesh.face_normals)[faces], float(np.linalg.norm(mesh.extents))


def _cell_by_cell(points: np.ndarray) -> np.ndarray:
    """An order [N] of points [N,3] in which neighbours follow each other."""
    low, extent = points.min(axis=0), max(float(np.ptp(points, axis=0).max()), 1e-12)
    return np.lexsort(np.floor((points - low) / extent * SORTING_CELLS).T)


def nearest_m(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """[N] distance of each of the points [N,3] to the nearest of the others [M,3]."""
    order, result = _cell_by_cell(points), np.empty(len(points))
    result[order] = cKDTree(others[_cell_by_cell(others)]).query(points[order])[0]
    return result


def seen_samples(points_T: np.ndarray, normals_T: np.ndarray, R_CT: Rotation, p_CT: np.ndarray) -> np.ndarray:
    """Mask [S] of the surface samples that face the camera and are not hidden in at least one view.

    A depth buffer of the samples themselves, in cells a little wider than their spacing.
    """
    seen = np.zeros(len(points_T), dtype=bool)
    for index in np.unique(np.linspace(0, len(p_CT) - 1, VIEWS).astype(int)):
        p_C = R_CT[index].apply(points_T) + p_CT[index]
        facing = np.einsum("ij,ij->i", R_CT[index].apply(normals_T), p_C) < 0
        if np.any(p_C[:, 2] <= 0):
            continue
        direction = p_C[:, :2] / p_C[:, 2:]
        low, high = direction.min(axis=0), direction.max(axis=0)
        cell = np.floor((direction - low) / (high - low).max() * DEPTH_CELLS).astype(int)
        key = cell[:, 0] * (DEPTH_CELLS + 1) + cell[:, 1]
        nearest = np.full((DEPTH_CELLS + 1) ** 2, np.inf)
        np.minimum.at(nearest, key, p_C[:, 2])
        # Two cells of slack along the ray: a slanted surface has several depths within one cell.
        slack = 2 * (high - low).max() / DEPTH_CELLS * p_C[:, 2]
        slope = np.abs(np.einsum("ij,ij->i", R_CT[index].apply(normals_T), p_C)) / np.linalg.norm(p_C, axis=1)
        seen |= facing & (p_C[:, 2] <= nearest[key] + slack / np.maximum(slope, 0.2))
    return seen


def cloud_in_truth(points_E: np.ndarray, aligned: Aligned, own_scale: bool = False) -> np.ndarray:
    """Cloud points of the estimate's frame in the truth's body frame [m]."""
    scale = 1.0 if own_scale else aligned.similarity.scale
    return scale * aligned.R_ET.inv().apply(points_E - aligned.similarity.offset_E)


def judge_shape(cloud_path: pathlib.Path, model_path: pathlib.Path, aligned: Aligned) -> dict[str, Any] | None:
    """Accuracy and completeness of a cloud's measured points, in % of the body's size; None where a file is missing."""
    if not cloud_path.exists() or not model_path.exists():
        return None
    points_E = read_cloud(cloud_path, measured_only=True)
    if len(points_E) == 0:
        return {"points": 0}
    surface_T, normals_T, size_m = sample_mesh(model_path)
    points_T = cloud_in_truth(points_E, aligned)
    distance = 100 * nearest_m(points_T, surface_T) / size_m
    seen = seen_samples(surface_T, normals_T, aligned.R_CT, aligned.truth.p_CT[aligned.rows_T])
    to_cloud = 100 * nearest_m(surface_T, points_T) / size_m
    result: dict[str, Any] = {
        "points": len(points_T),
        "body_size_m": size_m,
        "distance_rmse_percent": float(np.sqrt(np.mean(distance**2))),
        "distance_median_percent": float(np.median(distance)),
        "distance_p95_percent": float(np.percentile(distance, 95)),
        "seen_share_of_surface": float(seen.mean()),
    }
    for bound in COVERED_PERCENT:
        result[f"complete_within_{bound:g}_percent"] = float(np.mean(to_cloud <= bound))
        result[f"complete_seen_within_{bound:g}_percent"] = float(np.mean(to_cloud[seen] <= bound)) if seen.any() else None
    return result
