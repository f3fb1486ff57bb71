"""Reconstructs a surface from points with normals by pycolmap. Runs in COLMAP's own environment.

Call: surface_worker.py POINTS.ply SURFACE.ply DEPTH FACES. At most FACES triangles are left.
"""

import pathlib
import sys

import pycolmap


def count_faces(path: pathlib.Path) -> int:
    header = path.read_bytes().partition(b"end_header")[0]
    return int(header.partition(b"element face ")[2].split()[0])


def main() -> None:
    points, surface = (pathlib.Path(argument) for argument in sys.argv[1:3])
    depth, faces_max = (int(argument) for argument in sys.argv[3:5])
    options = pycolmap.PoissonMeshingOptions()
    options.depth, options.trim, options.num_threads = depth, 0.0, 1  # nothing is trimmed: the surface stays closed
    pycolmap.poisson_meshing(points, surface, options)
    if (found := count_faces(surface)) > faces_max:
        fewer = pycolmap.MeshSimplificationOptions()
        fewer.target_face_ratio, fewer.num_threads = faces_max / found, 1
        pycolmap.simplify_mesh(surface, surface, fewer)


if __name__ == "__main__":
    main()
