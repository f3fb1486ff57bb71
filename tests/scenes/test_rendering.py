"""Whole runs through Blender: pixel-exact truth, repeatability, resuming, refusals."""

import base64
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from polhode_ground.scenes import camera as cam
from polhode_ground.scenes import png
from polhode_ground.scenes.rotations import quat_to_matrix

ROOT = Path(__file__).resolve().parents[2]
RENDER = ROOT / "hil" / "render_scene.sh"

pytestmark = [pytest.mark.slow, pytest.mark.skipif(shutil.which("blender") is None, reason="Blender is not installed")]

# Corner points well off the dark box, not symmetric, each seen in some frames.
POINTS = [
    [0.7, 0.7, 0.7],
    [-0.7, 0.7, 0.6],
    [0.7, -0.7, -0.6],
    [-0.7, -0.6, 0.7],
    [0.7, 0.6, -0.7],
    [-0.6, 0.7, -0.7],
    [0.0, -0.9, 0.1],
]

SCENE = """
seed = 3
[target]
kind = "{kind}"
size_m = 1.0
texture_px = 256
fiducials_G_m = {points}
fiducial_radius_m = 0.016
[motion]
inertia_kg_m2 = [1.0, 1.2, 1.4]
w0_T_deg_s = [5.0, -7.0, 9.0]
q_CT0 = [0.8, 0.3, -0.4, 0.33]
p_CT0_m = [0.2, -0.1, 6.0]
v_C0_m_s = [0.01, 0.0, -0.05]
centre_of_mass_G_m = [0.06, -0.04, 0.05]
[camera]
resolution = [400, 300]
{camera}
[time]
frames = {frames}
period_s = 2.0
[light]
sun = 0.02
earthshine = 0.0
[sensor]
gamma = 1.0
{sensor}
[render]
samples = 32
"""

PLAIN = "intrinsics_px = [560.0, 560.0, 203.0, 146.5]"
DISTORTED = "intrinsics_px = [540.0, 546.0, 203.3, 146.1]\ndistortion = [-0.28, 0.09, 0.0012, -0.0015]"
WINDING = "intrinsics_px = [540.0, 546.0, 203.3, 146.1]\ndistortion = [-0.28, 0.09, 0.0012, -0.0015]\nw_C_deg_s = [0.2, -0.3, 1.5]"


def _run(scene, out, *more):
    return subprocess.run([RENDER, scene, out, *more], capture_output=True, text=True, timeout=600)


def _write(folder, camera=PLAIN, kind="box", frames=4, sensor="exposure = 0.8", points=POINTS):
    path = folder / "scene.toml"
    path.write_text(SCENE.format(camera=camera, kind=kind, frames=frames, sensor=sensor, points=points))
    return path


def _camera_of(sequence):
    """Reads sensor.yaml as a user would."""
    fields = dict(
        line.split("#")[0].strip().split(": ", 1)
        for line in (sequence / "mav0/cam0/sensor.yaml").read_text().splitlines()
    )
    size, k, d = (json.loads(fields[n]) for n in ("resolution", "intrinsics", "distortion_coefficients"))
    return cam.Camera(int(size[0]), int(size[1]), *k, tuple(d))


def _truth_rows(sequence):
    lines = (sequence / "truth.csv").read_text().splitlines()
    names = lines[0].split(",")
    return [dict(zip(names, map(float, line.split(",")))) for line in lines[1:]], [
        int(line.split(",")[0]) for line in lines[1:]
    ]


def _blob_centre(image, uv, radius=7):
    """Brightness centroid around uv, or None where no isolated blob is."""
    u, v = int(round(uv[0])), int(round(uv[1]))
    if not (radius < u < image.shape[1] - radius and radius < v < image.shape[0] - radius):
        return None
    patch = image[v - radius : v + radius + 1, u - radius : u + radius + 1].astype(float)
    patch = np.clip(patch - 40, 0, None)
    border = np.concatenate([patch[0], patch[-1], patch[:, 0], patch[:, -1]])
    if patch.max() < 80 or border.max() > 0:
        return None
    yy, xx = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    return np.array([u + (patch * xx).sum() / patch.sum(), v + (patch * yy).sum() / patch.sum()])


def residuals_px(sequence):
    """Measured minus projected fiducials, (N, 2)."""
    camera = _camera_of(sequence)
    points_T = np.array(json.loads((sequence / "scene.json").read_text())["fiducials_T_m"])
    rows, stamps = _truth_rows(sequence)
    out = []
    for row, stamp in zip(rows, stamps):
        image = png.decode((sequence / f"mav0/cam0/data/{stamp}.png").read_bytes())
        R_CT = quat_to_matrix([row[f"q_CT_{a}"] for a in "wxyz"])
        p_C = points_T @ R_CT.T + [row[f"p_CT_{a}"] for a in "xyz"]
        for uv in cam.project(camera, p_C):
            found = _blob_centre(image, uv)
            if found is not None:
                out.append(found - uv)
    return np.array(out)


@pytest.mark.parametrize("camera", [PLAIN, DISTORTED, WINDING], ids=["plain", "distorted", "distorted_turning"])
def test_truth_is_pixel_exact(tmp_path, camera):
    done = _run(_write(tmp_path, camera), tmp_path / "out")
    assert done.returncode == 0, done.stderr
    error = residuals_px(tmp_path / "out")
    print(
        f"\n{len(error)} points: mean {error.mean(axis=0)}, rms {np.sqrt((error ** 2).mean()):.4f}, max {np.abs(error).max():.4f} px"
    )
    assert len(error) >= 10
    assert np.linalg.norm(error, axis=1).max() < 0.3
    # A shift of half a pixel, the usual mistake, must not hide in the tolerance.
    assert np.abs(error.mean(axis=0)).max() < 0.05


def test_motion_blur_keeps_the_middle_of_the_exposure(tmp_path):
    scene = _write(tmp_path, sensor="exposure = 0.8\nexposure_s = 0.1\nblur_samples = 5")
    assert _run(scene, tmp_path / "out").returncode == 0
    error = residuals_px(tmp_path / "out")
    assert len(error) >= 8 and np.linalg.norm(error, axis=1).max() < 0.3


def test_the_same_scene_gives_the_same_bytes_and_an_interrupted_one_too(tmp_path):
    scene = _write(tmp_path, kind="cubesat", frames=3, points=[])
    for name in ("a", "b"):
        assert _run(scene, tmp_path / name).returncode == 0
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    before = {f: (tmp_path / "a" / f).read_bytes() for f in files}
    assert all((tmp_path / "b" / f).read_bytes() == data for f, data in before.items())
    lost = sorted((tmp_path / "a/mav0/cam0/data").glob("*.png"))[1:]
    for path in [*lost, tmp_path / "a/mav0/cam0/data.csv"]:
        path.unlink()
    again = _run(scene, tmp_path / "a")
    assert again.returncode == 0 and "2 to render" in again.stderr
    assert all((tmp_path / "a" / f).read_bytes() == data for f, data in before.items())
    # Another scene must not be mixed into this folder.
    scene.write_text(scene.read_text().replace("seed = 3", "seed = 4"))
    assert _run(scene, tmp_path / "a").returncode == 2


LABORATORY = """
seed = 3
[target]
kind = "box"
size_m = 0.15
texture_px = 256
[motion]
inertia_kg_m2 = [1.0, 1.2, 1.4]
w0_T_deg_s = [0.0, 0.0, 0.0]
q_CT0 = [1.0, 0.0, 0.0, 0.0]
p_CT0_m = [-0.12, -0.06, 0.6]
v_C0_m_s = [0.24, 0.0, 0.0]
[camera]
resolution = [240, 180]
lens_mm = 28.0
[time]
frames = 2
period_s = 1.0
[background]
kind = "laboratory"
up_C = [0.0, -1.0, 0.0]
table_below_m = 0.15
[sensor]
bits = 16
gamma = 1.0
full_well_e = 1000000
[render]
samples = 4
"""


@pytest.mark.further
def test_a_body_in_the_laboratory_throws_its_shadow_on_the_table_and_changes_nothing_else(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(LABORATORY)
    assert _run(scene, tmp_path / "out").returncode == 0
    frames = sorted((tmp_path / "out/mav0/cam0/data").glob("*.png"))
    first, second = (png.decode(path.read_bytes()).astype(float) for path in frames)
    rows, _ = _truth_rows(tmp_path / "out")
    camera = _camera_of(tmp_path / "out")
    for row, shaded, free in ((rows[0], first, second), (rows[1], second, first)):
        u, v = cam.project(camera, np.array([row["p_CT_x"], row["p_CT_y"] + 0.15, row["p_CT_z"]])).astype(int)
        patch = np.s_[v - 3 : v + 4, u - 3 : u + 4]
        assert shaded[patch].mean() < 0.9 * free[patch].mean()
    # The wall high above the body and the table's near corners: only the sensor's noise differs, 0.3 % at mid-grey.
    for patch in (np.s_[:20, :], np.s_[-15:, :30], np.s_[-15:, -30:]):
        assert abs(first[patch].mean() / second[patch].mean() - 1) < 1e-3
    before = frames[1].read_bytes()
    frames[1].unlink()
    assert _run(scene, tmp_path / "out").returncode == 0
    assert frames[1].read_bytes() == before


def test_a_refusal_is_one_line_and_leaves_nothing_behind(tmp_path):
    scene = _write(tmp_path)
    text = scene.read_text()
    for old, new, words in (
        ("seed = 3", "sead = 3", "unknown key sead"),
        ("[1.0, 1.2, 1.4]", "[1.0, 1.2, -1.4]", "must be positive"),
        ("[1.0, 1.2, 1.4]", "[1.0, 1.2, 2.4]", "exceeds the sum"),
        ("[0.2, -0.1, 6.0]", "[9.2, -0.1, 6.0]", "out of view"),
        ('kind = "box"', 'kind = "file"\npath = "no.stl"', "no model file"),
        ("frames = 4", 'frames = "4"', "a whole number"),
    ):
        assert old in text
        scene.write_text(text.replace(old, new))
        done = _run(scene, tmp_path / "out")
        assert done.returncode == 2 and words in done.stderr, done.stderr
        assert len(done.stderr.strip().splitlines()) == 1 and not (tmp_path / "out").exists()


CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.25, 0.25) for z in (-0.1, 0.1)], dtype="<f4")
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
TRIANGLES = np.array([t for q in QUADS for t in (q[:3], [q[0], q[2], q[3]])], dtype="<u2")


def _obj(path):
    path.write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
        + "".join("f " + " ".join(str(i + 1) for i in q) + "\n" for q in QUADS)
    )


def _stl(path):
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*CORNERS[i]) for i in t)
        + "endloop\nendfacet\n"
        for t in TRIANGLES
    ]
    path.write_text("solid m\n" + "".join(facets) + "endsolid m\n")


def _ply(path):
    head = (
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 12\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    path.write_text(
        head + "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + "".join("3 {} {} {}\n".format(*t) for t in TRIANGLES)
    )


def _gltf(path):
    data = CORNERS.tobytes() + TRIANGLES.tobytes()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}]
    accessors = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": 8,
            "type": "VEC3",
            "min": CORNERS.min(axis=0).tolist(),
            "max": CORNERS.max(axis=0).tolist(),
        },
        {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
    ]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    path.write_text(
        json.dumps(
            {
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
                "materials": [
                    {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1.0], "metallicFactor": 0.0}}
                ],
                "accessors": accessors,
                "bufferViews": views,
                "buffers": [{"byteLength": len(data), "uri": uri}],
            }
        )
    )


@pytest.mark.parametrize("kind, write", [("obj", _obj), ("stl", _stl), ("ply", _ply), ("gltf", _gltf)])
def test_an_imported_model_keeps_its_own_axes(tmp_path, kind, write):
    write(tmp_path / f"m.{kind}")
    scene = _write(tmp_path, points=[], frames=1)
    text = scene.read_text().replace('kind = "box"', f'kind = "file"\npath = "m.{kind}"\nscale = 2.0')
    scene.write_text(text.replace("sun = 0.02", "sun = 1.0\nsun_direction_C = [0.1, -0.1, -1.0]"))
    done = _run(scene, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    low, high = json.loads((tmp_path / "out/scene.json").read_text())["bounding_box_T_m"]
    offset = np.array([0.06, -0.04, 0.05])
    assert np.allclose(low, [-1, -0.5, -0.2] - offset, atol=1e-6) and np.allclose(
        high, [1, 0.5, 0.2] - offset, atol=1e-6
    )
    # The silhouette is the projection of the corners: the box is drawn where its mesh is said to be.
    image = png.decode(next((tmp_path / "out/mav0/cam0/data").glob("*.png")).read_bytes())
    row = _truth_rows(tmp_path / "out")[0][0]
    R_CT = quat_to_matrix([row[f"q_CT_{a}"] for a in "wxyz"])
    uv = cam.project(_camera_of(tmp_path / "out"), (2 * CORNERS - offset) @ R_CT.T + [row[f"p_CT_{a}"] for a in "xyz"])
    lit = np.argwhere(image > 12)[:, ::-1]
    assert np.all(lit.min(axis=0) > uv.min(axis=0) - 2) and np.all(lit.max(axis=0) < uv.max(axis=0) + 2)
    assert len(lit) > 0.3 * np.prod(np.ptp(uv, axis=0)) / 2


# Two plates side by side, the left one bright, the right one dark, in each format's own way.
PLATES = np.array([[x, y, 0] for x in (-0.5, 0.0) for y in (-0.25, 0.25)] + [[x, y, 0] for x in (0.0, 0.5) for y in (-0.25, 0.25)], "<f4")
PLATE_QUADS = [[0, 2, 3, 1], [4, 6, 7, 5]]
BRIGHT, DARK = 0.8, 0.04


def _plates_obj(path):
    path.with_suffix(".mtl").write_text("".join(f"newmtl {n}\nKd {v} {v} {v}\n" for n, v in (("bright", BRIGHT), ("dark", DARK))))
    faces = "".join(f"usemtl {n}\nf " + " ".join(str(i + 1) for i in q) + "\n" for n, q in zip(("bright", "dark"), PLATE_QUADS))
    path.write_text("mtllib m.mtl\n" + "".join("v {} {} {}\n".format(*v) for v in PLATES) + faces)


def _plates_textured_obj(path):
    path.with_name("halves.png").write_bytes(png.encode(np.full((16, 16), 50, np.uint8) + np.uint8(180) * (np.arange(16) < 8).astype(np.uint8)))
    path.with_suffix(".mtl").write_text("newmtl both\nKd 1 1 1\nmap_Kd halves.png\n")
    corners = "".join("v {} {} {}\nvt {} {}\n".format(*v, v[0] + 0.5, 2 * v[1] + 0.5) for v in PLATES)
    faces = "".join("f " + " ".join(f"{i + 1}/{i + 1}" for i in q) + "\n" for q in PLATE_QUADS)
    path.write_text("mtllib m.mtl\nusemtl both\n" + corners + faces)


def _plates_ply(path):
    head = "ply\nformat ascii 1.0\nelement vertex 8\n" + "".join(f"property float {a}\n" for a in "xyz")
    head += "".join(f"property uchar {c}\n" for c in ("red", "green", "blue"))
    head += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    corners = "".join("{} {} {} {c} {c} {c}\n".format(*v, c=230 if i < 4 else 50) for i, v in enumerate(PLATES))
    path.write_text(head + corners + "".join("4 {} {} {} {}\n".format(*q) for q in PLATE_QUADS))


def _plates_gltf(path):
    indices = np.array([i for q in PLATE_QUADS for i in (*q[:3], q[0], *q[2:])], "<u2")
    data = PLATES.tobytes() + indices.tobytes()
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-0.5, -0.25, 0], "max": [0.5, 0.25, 0]}]
    accessors += [{"bufferView": 1, "byteOffset": 12 * k, "componentType": 5123, "count": 6, "type": "SCALAR"} for k in (0, 1)]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    materials = [{"doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [v, v, v, 1], "metallicFactor": 0}} for v in (BRIGHT, DARK)]
    primitives = [{"attributes": {"POSITION": 0}, "indices": 1 + k, "material": k} for k in (0, 1)]
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": primitives}],
        "materials": materials, "accessors": accessors, "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 24}]}))


@pytest.mark.parametrize("write", [_plates_obj, _plates_textured_obj, _plates_ply, _plates_gltf])
def test_an_imported_model_keeps_its_materials(tmp_path, write):
    kind = write.__name__.rsplit("_", 1)[1]
    write(tmp_path / f"m.{kind}")
    (tmp_path / "s.toml").write_text(
        f'[target]\nkind = "file"\npath = "m.{kind}"\n[motion]\ninertia_kg_m2 = [1, 1, 1]\nw0_T_deg_s = [0, 0, 0]\nv_C0_m_s = [0, 0, 0]\nq_CT0 = [0, 1, 0, 0]\np_CT0_m = [0, 0, 3]\n'
        "[camera]\nresolution = [160, 120]\n[time]\nframes = 1\n[light]\nsun_direction_C = [0.1, -0.1, -1]\nearthshine = 0.0\n"
    )
    done = _run(tmp_path / "s.toml", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    image = png.decode(next((tmp_path / "out/mav0/cam0/data").glob("*.png")).read_bytes())
    # The body's x goes to the right of the image. 1 m of it, 160 px * 50 / 36 of focal length, 3 m away: 74 px about the middle.
    left, right = np.median(image[50:70, 50:75]), np.median(image[50:70, 86:110])
    assert left > 180 and 20 < right < 110, (left, right)


def test_threads_change_no_pixel_and_a_turning_camera_tells_its_attitude(tmp_path):
    scene = _write(tmp_path, WINDING, kind="cubesat", frames=1)
    for threads in ("1", "2"):
        assert _run(scene, tmp_path / threads, "--threads", threads).returncode == 0
    pictures = [next((tmp_path / threads / "mav0/cam0/data").glob("*.png")).read_bytes() for threads in ("1", "2")]
    assert pictures[0] == pictures[1]
    header, row = (tmp_path / "1/servicer_attitude.csv").read_text().splitlines()
    assert header == "#timestamp_ns,q_IC_w,q_IC_x,q_IC_y,q_IC_z"
    assert [float(x) for x in row.split(",")[1:]] == [1.0, 0.0, 0.0, 0.0]
    assert not (tmp_path / "missing").exists() and _run(scene, tmp_path / "missing", "--threads", "0").returncode == 2
