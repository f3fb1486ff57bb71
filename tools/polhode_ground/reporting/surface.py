"""A surface that follows the cloud: Poisson reconstruction by pycolmap, with the parts that nothing measured marked."""

import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import in_frame, read_motion, target_frames
from polhode_ground.common.whole_file import MARK, REPLAY_MARK, check_replaceable, write_whole
from polhode_ground.judge import align
from polhode_ground.judge.colmap import ensure_venv
from polhode_ground.judge.shape import load_ply, property_of
from polhode_ground.reporting.video import observations_by_time

WORKER = pathlib.Path(__file__).with_name("surface_worker.py")
# With fewer points a surface is a guess; a face of a box alone needs a dozen.
POINTS_MIN = 100
# Cells of the octree in pitches of the cloud. Finer ones follow the noise, see decision 0086.
CELL_PITCHES = 2.0
DEPTH_MAX = 9
# Enough to follow what some thousand points resolve, few enough to be drawn over a frame.
FACES_MAX = 4000
# A place this far from every measured point was not measured: random points of one pitch leave no wider hole (exp(-2.5^2 pi) = 3e-9).
REACH_PITCHES = 2.5
SIDE_POINTS_MAX = 20_000
SIGHTS_MIN = 3  # a single line of sight may be that of a wrong landmark
PIECE_MIN = 0.05  # of the faces
HULL_STEPS = 4  # a point beyond a corner is beyond three facets
MEASURED_RGB, ADDED_RGB = (200, 200, 200), (240, 140, 40)  # as in cloud.ply
COMMENT = "Poisson surface of cloud.ply, body frame; orange, added = 1: no measured point is near"


def read_points(path: pathlib.Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(points [N,3], unit normals [N,3], added [N] bool) of a cloud.ply, those without a normal left out."""
    if not path.exists():
        raise BadInput(f"{path}: not there; DIR must be the output folder of a replay")
    mesh = load_ply(path)
    points = np.asarray(getattr(mesh, "vertices", np.empty((0, 3))), dtype=float)
    normals = [property_of(mesh, name, len(points)) for name in ("nx", "ny", "nz")]
    added = property_of(mesh, "added", len(points))
    if len(points) and any(one is None for one in [*normals, added]):
        raise BadInput(f"{path}: holds no normals (nx, ny, nz) or no mark (added); replay the sequence again")
    if len(points) < POINTS_MIN:
        raise BadInput(f"{path}: {len(points)} points, at least {POINTS_MIN} are needed for a surface")
    normals = np.stack(normals, axis=1).astype(float)
    good = np.isfinite(points).all(axis=1) & (np.linalg.norm(normals, axis=1) > 0.5)
    if (measured := int((good & (added == 0)).sum())) < POINTS_MIN:
        raise BadInput(f"{path}: {measured} measured points with a normal, at least {POINTS_MIN} are needed for a surface")
    return points[good], normals[good], added[good] > 0


def pitch_of(points: np.ndarray) -> float:
    """Distance of evenly spread points as dense as these: 1 / sqrt(points per area), by the fourth neighbour of each."""
    fourth = np.median(cKDTree(points).query(points, k=5)[0][:, 4])
    return float(fourth) / math.sqrt(4 / math.pi)  # a disc of that radius holds four of them


def lines_of_sight(folder: pathlib.Path) -> tuple[np.ndarray, np.ndarray]:
    """(landmarks [M,3], cameras [M,3]) in the frame of cloud.ply: what lies between the two is empty. Once for each time that one was seen."""
    landmarks = load_ply(folder / "cloud_raw.ply")
    numbers = property_of(landmarks, "landmark", len(getattr(landmarks, "vertices", ())))
    motion = read_motion(folder / "motion_smoothed.csv")
    last = in_frame(motion, target_frames(motion)[-1])
    rows = {int(last.timestamp_ns[row]): row for row in np.flatnonzero(last.pose_valid)}
    places = {int(number): place for place, number in enumerate(numbers if numbers is not None else ())}
    camera_T = np.full((len(last.timestamp_ns), 3), np.nan)
    camera_T[last.pose_valid] = -align.rotations(last.q_CT[last.pose_valid]).inv().apply(last.p_CT[last.pose_valid])
    seen = [
        (places[number], rows[time_ns])
        for time_ns, found in observations_by_time(folder / "observations.csv")
        if time_ns in rows
        for number, (_, _, inlier) in found.items()
        if inlier and number in places
    ]
    if not seen:
        return np.empty((0, 3)), np.empty((0, 3))
    at, row = np.array(seen).T
    return np.asarray(landmarks.vertices, dtype=float)[at], camera_T[row]


def within(hull: ConvexHull, points: np.ndarray) -> np.ndarray:
    """Points that lie outside of a convex hull, moved onto it: no body reaches beyond the hull of what was seen of its outline."""
    points = points.copy()
    for _ in range(HULL_STEPS):
        beyond = points @ hull.equations[:, :3].T + hull.equations[:, 3]
        points -= np.maximum(beyond.max(axis=1), 0.0)[:, None] * hull.equations[beyond.argmax(axis=1), :3]
    return points


def unseen_sides(hull: ConvexHull, points: np.ndarray, sight: tuple[np.ndarray, np.ndarray], pitch: float) -> tuple[np.ndarray, np.ndarray]:
    """(points, normals) on the convex hull where nothing was measured and no line of sight leaves the body: there the hull is the best guess."""
    import trimesh

    facets = trimesh.Trimesh(hull.points, hull.simplices, process=False)
    samples, faces = trimesh.sample.sample_surface(facets, min(SIDE_POINTS_MAX, math.ceil(hull.area / pitch**2)), seed=1)
    samples, reach = np.asarray(samples), REACH_PITCHES * pitch
    lonely = cKDTree(points).query(samples)[0] > reach
    from_T, to_T = sight
    if len(from_T):
        step = to_T - from_T
        with np.errstate(divide="ignore", invalid="ignore"):  # the facet through which the line leaves: the first that is ahead
            ahead = step @ hull.equations[:, :3].T
            away = -(from_T @ hull.equations[:, :3].T + hull.equations[:, 3]) / ahead
        away = np.where(ahead > 0, away, np.inf).min(axis=1)
        leaves = from_T + np.maximum(away, 0)[:, None] * step
        lonely &= np.array(
            [len(near) < SIGHTS_MIN for near in cKDTree(leaves[np.isfinite(leaves).all(axis=1)]).query_ball_point(samples, reach)]
        )
    return samples[lonely], hull.equations[faces[lonely], :3]


def without_islands(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Only the pieces that hold a good part of the faces: noise makes bubbles."""
    edges = np.concatenate([faces[:, :2], faces[:, 1:]])
    links = coo_array((np.ones(len(edges)), edges.T), shape=(len(vertices),) * 2)
    piece = connected_components(links, directed=False)[1][faces[:, 0]]
    faces = faces[(np.bincount(piece) >= PIECE_MIN * len(faces))[piece]]
    used, faces = np.unique(faces, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


def write_points(path: pathlib.Path, points: np.ndarray, normals: np.ndarray) -> None:
    """As COLMAP reads them."""
    rows = np.zeros(len(points), dtype=[("place", "<f4", 3), ("normal", "<f4", 3), ("rgb", "u1", 3)])
    rows["place"], rows["normal"] = points, normals
    names = [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")] + [
        f"property uchar {name}" for name in ("red", "green", "blue")
    ]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", *names, "end_header", ""]
    path.write_bytes("\n".join(header).encode() + rows.tobytes())


def write_surface(path: pathlib.Path, vertices: np.ndarray, faces: np.ndarray, added: np.ndarray) -> None:
    """surface.ply with its mark on each vertex, put in place whole, whatever stood there."""
    corners = np.zeros(len(vertices), dtype=[("place", "<f4", 3), ("rgb", "u1", 3), ("added", "u1")])
    corners["place"], corners["rgb"], corners["added"] = vertices, np.where(added[:, None], ADDED_RGB, MEASURED_RGB), added
    triangles = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    names = [*(f"property float {name}" for name in "xyz"), *(f"property uchar {name}" for name in ("red", "green", "blue", "added"))]
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment {COMMENT}",
        f"comment {MARK}",
        f"element vertex {len(vertices)}",
        *names,
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
        "",
    ]
    write_whole(path, "\n".join(header).encode() + corners.tobytes() + triangles.tobytes(), ours=True)


def reconstruct(points: np.ndarray, normals: np.ndarray, pitch: float) -> tuple[np.ndarray, np.ndarray]:
    """(vertices [V,3], faces [F,3]) of a closed surface through points with normals."""
    size = float(np.ptp(points, axis=0).max())
    depth = min(DEPTH_MAX, max(3, math.ceil(math.log2(1.1 * size / (CELL_PITCHES * pitch)))))
    with tempfile.TemporaryDirectory() as place:
        work = pathlib.Path(place)
        write_points(work / "points.ply", points, normals)
        done = subprocess.run(
            [ensure_venv(), WORKER, work / "points.ply", work / "surface.ply", str(depth), str(FACES_MAX)],
            capture_output=True,
            text=True,
            errors="backslashreplace",
        )
        if done.returncode != 0:
            raise BadInput(
                f"the surface can't be made: pycolmap ended with {done.returncode}: {' '.join(done.stderr.strip().splitlines()[-1:])}"
            )
        mesh = load_ply(work / "surface.ply")
    if len(getattr(mesh, "faces", ())) == 0:
        raise BadInput("the surface can't be made: pycolmap found none through these points")
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def make_surface(folder: pathlib.Path) -> tuple[int, float]:
    """Writes folder/surface.ply, or replaces the one of an earlier call. @return (faces, part of the area that was measured)."""
    points, normals, added = read_points(folder / "cloud.ply")
    if not (folder / REPLAY_MARK).exists():  # a replay leaves a convex hull under this name
        check_replaceable(folder / "surface.ply")
    measured = points[~added]
    pitch = pitch_of(measured)
    try:
        hull = ConvexHull(points)
    except QhullError:
        raise BadInput(f"{folder / 'cloud.ply'}: its points enclose no volume") from None
    sides, side_normals = unseen_sides(hull, points, lines_of_sight(folder), pitch)
    print(f"surface of {len(points)} points, some seconds", file=sys.stderr)
    vertices, faces = without_islands(*reconstruct(np.concatenate([points, sides]), np.concatenate([normals, side_normals]), pitch))
    vertices = within(hull, vertices)
    marks = cKDTree(measured).query(vertices)[0] > REACH_PITCHES * pitch
    write_surface(folder / "surface.ply", vertices, faces, marks)
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return len(faces), float(area[~marks[faces].any(axis=1)].sum() / area.sum())
