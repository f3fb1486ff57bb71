"""Mesh parts as plain arrays, and builders for the simple shapes that targets are made of.

All vertices are in the target's geometric frame G, in metres.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Part:
    """A mesh with one material.

    vertices_G_m (N, 3); faces (M, k) int, k = 3 or 4, counter-clockwise seen from outside; uv (M, k, 2).
    """

    name: str
    vertices_G_m: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    material: str
    smooth: bool = False


def grid_patch(name, origin, edge_u, edge_v, counts, material, height_m=None, smooth=False):
    """Rectangle origin + s*edge_u + t*edge_v (normal along edge_u x edge_v), divided (nu, nv); uv covers [0, 1].

    height_m (nv + 1, nu + 1) displaces along the normal.
    """
    nu, nv = counts
    origin, edge_u, edge_v = (np.asarray(a, dtype=float) for a in (origin, edge_u, edge_v))
    s, t = np.meshgrid(np.linspace(0, 1, nu + 1), np.linspace(0, 1, nv + 1))
    points = origin + s[..., None] * edge_u + t[..., None] * edge_v
    if height_m is not None:
        normal = np.cross(edge_u, edge_v)
        points = points + height_m[..., None] * normal / np.linalg.norm(normal)
    faces = grid_faces(nu + 1, nv + 1)
    uv = np.stack([s, t], axis=-1).reshape(-1, 2)[faces]
    return Part(name, points.reshape(-1, 3), faces, uv, material, smooth)


def grid_faces(columns, rows):
    """Quads (M, 4) of a vertex grid stored row by row."""
    i = np.arange(columns - 1)[None, :] + columns * np.arange(rows - 1)[:, None]
    i = i.reshape(-1)
    return np.stack([i, i + 1, i + 1 + columns, i + columns], axis=1)


def box(name, low, high, material, bevel_m=0.0):
    """Axis-aligned box. With a bevel, edges and corners are cut, so that they catch the light as real edges do."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    b = min(bevel_m, 0.45 * float((high - low).min()))
    if b <= 0:
        return _plain_box(name, low, high, material)
    vertices, index = [], {}
    for corner in np.ndindex(2, 2, 2):
        for axis in range(3):
            p = np.where(np.array(corner) == 1, high - b, low + b)
            p[axis] = high[axis] if corner[axis] else low[axis]
            index[corner, axis] = len(vertices)
            vertices.append(p)
    quads, triangles = [], []
    for axis in range(3):
        a1, a2 = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            ring = [(0, 0), (1, 0), (1, 1), (0, 1)] if side else [(0, 0), (0, 1), (1, 1), (1, 0)]
            quads.append([index[_corner(axis, side, a1, r[0], a2, r[1]), axis] for r in ring])
        for s1 in (0, 1):
            for s2 in (0, 1):
                c0, c1 = _corner(axis, 0, a1, s1, a2, s2), _corner(axis, 1, a1, s1, a2, s2)
                quad = [index[c0, a1], index[c0, a2], index[c1, a2], index[c1, a1]]
                quads.append(quad if s1 != s2 else quad[::-1])
    for corner in np.ndindex(2, 2, 2):
        tri = [index[corner, 0], index[corner, 1], index[corner, 2]]
        triangles.append(tri if sum(corner) % 2 else tri[::-1])
    vertices = np.array(vertices)
    # One part has faces of one kind, and the cut corners are triangles: split the quads, too.
    faces = [t for q in quads for t in ([q[0], q[1], q[2]], [q[0], q[2], q[3]])] + triangles
    faces = _outward(vertices, np.array(faces), (low + high) / 2)
    return Part(name, vertices, faces, box_uv(vertices, faces), material)


def _corner(axis, side, a1, s1, a2, s2):
    corner = [0, 0, 0]
    corner[axis], corner[a1], corner[a2] = side, s1, s2
    return tuple(corner)


def _outward(vertices, faces, centre):
    """Faces of a convex body, each turned so that its normal points away from the centre."""
    p = vertices[faces]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    inward = np.sum(normal * (p.mean(axis=1) - centre), axis=1) < 0
    out = faces.copy()
    out[inward] = out[inward][:, ::-1]
    return out


def _plain_box(name, low, high, material):
    x = [low, high]
    vertices = np.array([[x[i][0], x[j][1], x[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    quads = _outward(vertices, quads, (low + high) / 2)
    return Part(name, vertices, quads, box_uv(vertices, quads), material)


def box_uv(vertices, faces, scale_per_m=None):
    """Planar uv per face along its dominant axis; scaled to the bounding box, or by scale_per_m."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    unit = (vertices - low) * scale_per_m if scale_per_m else (vertices - low) / np.maximum(high - low, 1e-9)
    p = vertices[faces]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    axis = np.argmax(np.abs(normal), axis=1)
    first, second = np.array([1, 0, 0])[axis], np.array([2, 2, 1])[axis]
    corner = unit[faces]
    rows = np.arange(len(faces))[:, None]
    cols = np.arange(faces.shape[1])[None, :]
    return np.stack([corner[rows, cols, first[:, None]], corner[rows, cols, second[:, None]]], axis=-1)


def lathe(name, profile, origin, axis, material, segments=48, smooth=True, v_range=(0.0, 1.0)):
    """Surface of revolution. profile (N, 2): (distance along axis, radius), outward when axis goes up and the
    profile is listed upward. origin (3,), axis (3,). u goes once around, v along the profile."""
    origin, axis = np.asarray(origin, dtype=float), np.asarray(axis, dtype=float)
    axis = axis / np.linalg.norm(axis)
    helper = np.array([1.0, 0, 0]) if abs(axis[0]) < 0.9 else np.array([0, 1.0, 0])
    e1 = np.cross(axis, helper)
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(axis, e1)
    profile = np.asarray(profile, dtype=float)
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    ring = np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2
    points = origin + profile[:, None, 0:1] * axis + profile[:, None, 1:2] * ring[None]
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    v = v_range[0] + (v_range[1] - v_range[0]) * length / max(length[-1], 1e-12)
    uu, vv = np.meshgrid(angle / (2 * np.pi), v)
    faces = grid_faces(segments + 1, len(profile))
    uv = np.stack([uu, vv], axis=-1).reshape(-1, 2)[faces]
    return Part(name, points.reshape(-1, 3), faces, uv, material, smooth)


def cylinder(name, start, end, radius_m, material, segments=24, caps=True):
    """Closed cylinder from start to end, as a lathe with flat caps."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(end - start))
    # Repeated rims keep the shading of caps and side apart.
    profile = [(0, radius_m), (length, radius_m)]
    if caps:
        profile = [(0, 0), (0, radius_m), (0, radius_m), (length, radius_m), (length, radius_m), (length, 0)]
    return lathe(name, profile, start, end - start, material, segments, smooth=False)


def sphere(name, centre, radius_m, material, segments=24, rings=12):
    """UV sphere."""
    polar = np.linspace(0, np.pi, rings + 1)
    profile = np.stack([-radius_m * np.cos(polar), radius_m * np.sin(polar)], axis=1)
    return lathe(name, profile, centre, [0, 0, 1], material, segments)


def tube(name, path, radius_m, material, segments=8):
    """Bent tube along path (N, 3), for cables and pipes."""
    path = np.asarray(path, dtype=float)
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    e1 = np.cross(tangent[0], [0.31, 0.83, 0.47])
    rings = []
    for p, t in zip(path, tangent):
        e1 = e1 - np.dot(e1, t) * t
        e1 /= np.linalg.norm(e1)
        e2 = np.cross(t, e1)
        angle = np.linspace(0, 2 * np.pi, segments + 1)
        rings.append(p + radius_m * (np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2))
    faces = grid_faces(segments + 1, len(path))
    uv = np.stack(np.meshgrid(np.linspace(0, 1, segments + 1), np.linspace(0, 1, len(path))), axis=-1)
    return Part(name, np.concatenate(rings), faces, uv.reshape(-1, 2)[faces], material, True)


def rotate(part, R, pivot):
    """The part turned by R (3, 3) about pivot (3,)."""
    pivot = np.asarray(pivot, dtype=float)
    part.vertices_G_m = (part.vertices_G_m - pivot) @ np.asarray(R).T + pivot
    return part


def all_vertices(parts):
    """(N, 3) vertices of all parts."""
    return np.concatenate([p.vertices_G_m for p in parts])


def write_ply(path, parts, origin_G_m):
    """Binary PLY of all parts in T: vertices are G coordinates minus origin_G_m (the centre of mass)."""
    vertices, triangles, offset = [], [], 0
    for part in parts:
        vertices.append(part.vertices_G_m - origin_G_m)
        f = part.faces + offset
        triangles.append(f if f.shape[1] == 3 else np.concatenate([f[:, [0, 1, 2]], f[:, [0, 2, 3]]]))
        offset += len(part.vertices_G_m)
    vertices = np.concatenate(vertices).astype("<f4")
    triangles = np.concatenate(triangles)
    p = vertices[triangles].astype(float)
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    triangles = triangles[area > 1e-14]
    rows = np.empty(len(triangles), dtype=[("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, triangles
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment target mesh in T [m], origin at the centre of mass\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    with open(path, "wb") as file:
        file.write(header.encode() + vertices.tobytes() + rows.tobytes())
