"""The meshes and their textures."""

import numpy as np
import pytest
from polhode_ground.scenes import mesh, noise, surfaces
from polhode_ground.scenes.targets import box, cubesat, damaged_cube, upper_stage

BUILDERS = {"box": box, "cubesat": cubesat, "damaged_cube": damaged_cube, "upper_stage": upper_stage}


@pytest.mark.parametrize("name", BUILDERS)
def test_parts_are_sound_and_have_materials(name):
    parts, materials, known = BUILDERS[name].build(1.0, 3, 128)
    for part in parts:
        assert part.faces.min() >= 0 and part.faces.max() < len(part.vertices_G_m)
        assert part.uv.shape == (*part.faces.shape, 2) and np.all(np.isfinite(part.vertices_G_m))
        assert part.material in materials
    for item in known:
        assert np.isclose(np.linalg.norm(np.subtract(item["a_G_m"], item["b_G_m"])), item["length_m"])


@pytest.mark.parametrize("name", BUILDERS)
def test_size_scales_the_mesh(name):
    small, large = (mesh.all_vertices(BUILDERS[name].build(s, 3, 64)[0]) for s in (1.0, 2.5))
    assert np.allclose(large, 2.5 * small, atol=1e-9)
    assert 0.9 < (small.max(axis=0) - small.min(axis=0)).max() < 1.35


def test_detail_follows_its_seed():
    one, same, other = (cubesat.build(1.0, seed, 128)[1]["foil_gold"].color for seed in (1, 1, 2))
    assert np.array_equal(one, same) and not np.array_equal(one, other)


def test_a_bevelled_box_is_closed_and_faces_outward():
    part = mesh.box("b", [-1, -2, -3], [1, 2, 3], "m", 0.1)
    p = part.vertices_G_m[part.faces]
    volume = np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6
    # 48 less what 12 edges (triangular prisms of 0.1^2/2) and 8 corners lose; by hand 47.9 < 48 - 0.005*48 + corners.
    assert 47.7 < volume < 47.9
    edges = np.sort(np.concatenate([part.faces[:, [0, 1]], part.faces[:, [1, 2]], part.faces[:, [2, 0]]]), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert np.all(count == 2)


def test_the_ply_holds_the_mesh_about_the_centre_of_mass(tmp_path):
    parts, _, _ = box.build(2.0, 0, 64)
    mesh.write_ply(tmp_path / "m.ply", parts, np.array([0.25, 0.0, 0.0]))
    data = (tmp_path / "m.ply").read_bytes()
    head, body = data.split(b"end_header\n")
    count = int(head.split(b"element vertex ")[1].split()[0])
    vertices = np.frombuffer(body[: 12 * count], dtype="<f4").reshape(-1, 3)
    assert np.allclose(vertices.min(axis=0), [-1.25, -1, -1]) and np.allclose(vertices.max(axis=0), [0.75, 1, 1])


def test_textures_have_structure_at_fine_and_coarse_scale():
    rng = noise.generator(1)
    for made in (
        surfaces.foil((512, 512), 1000, rng),
        surfaces.solar_cells((512, 512), 1000, rng),
        surfaces.plate((512, 512), 1000, rng),
    ):
        gray = made.color.mean(axis=2)
        coarse = gray.reshape(16, 32, 16, 32).mean(axis=(1, 3))
        assert np.abs(np.diff(gray, axis=1)).mean() > 0.003 and coarse.std() > 0.008
        assert gray.min() >= 0 and gray.max() <= 1
