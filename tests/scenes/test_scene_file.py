"""What the generator refuses, and how it says so."""

from pathlib import Path

import pytest
from generator import scene_file

SCENES = Path(__file__).resolve().parents[2] / "hil" / "scenes"
STANDARD = ("paper_3d", "paper_2d", "earth", "damaged", "upper_stage", "fast_tumble", "far", "spin", "still")

GOOD = {
    "target": {"kind": "box"},
    "motion": {
        "inertia_kg_m2": [1.0, 1.0, 1.0],
        "w0_T_deg_s": [0, 0, 1.0],
        "q_CT0": [1, 0, 0, 0],
        "p_CT0_m": [0, 0, 5.0],
    },
}


def _with(table, key, value):
    return {**GOOD, table: {**GOOD.get(table, {}), key: value}}


def test_a_minimal_scene_is_filled_with_defaults():
    scene = scene_file.check(GOOD)
    assert scene["camera"]["resolution"] == [1920, 1080] and scene["background"]["kind"] == "none"


@pytest.mark.parametrize(
    "raw, words",
    [
        (_with("target", "colour", 1), "unknown key target.colour"),
        ({**GOOD, "targets": {}}, "unknown key targets"),
        (_with("time", "frames", 2.5), "time.frames: a whole number expected"),
        (_with("time", "frames", True), "time.frames: a whole number expected"),
        (_with("motion", "p_CT0_m", [0, 0]), "motion.p_CT0_m: 3 numbers expected"),
        (_with("motion", "p_CT0_m", [0, 0, float("nan")]), "3 numbers expected"),
        (_with("target", "kind", "teapot"), "target.kind: one of"),
        (_with("motion", "inertia_kg_m2", [1.0, -1.0, 1.0]), "must be positive"),
        (_with("motion", "inertia_kg_m2", [1.0, 1.0, 2.5]), "exceeds the sum"),
        (_with("motion", "inertia_kg_m2", [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "not symmetric"),
        (_with("motion", "inertia_kg_m2", [[1, 0, 0], [0, 1, 0]]), "3 rows of 3"),
        (_with("motion", "translation", "teleport"), "constant or hcw"),
        (_with("sensor", "bits", 12), "8 or 16"),
        (_with("background", "kind", "mars"), "background.kind"),
        (_with("sensor", "exposure_s", 11.0), "exposure_s"),
        ({"target": {"kind": "box"}}, "motion.inertia_kg_m2 is missing"),
    ],
)
def test_a_bad_scene_is_refused_in_one_line(raw, words):
    with pytest.raises(scene_file.SceneError) as error:
        scene_file.check(raw)
    assert words in str(error.value) and "\n" not in str(error.value)


def test_the_papers_inertia_is_physical():
    assert scene_file.check(_with("motion", "inertia_kg_m2", [0.47, 0.47, 0.02]))


def test_a_missing_model_is_named(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(
        '[target]\nkind = "file"\npath = "none.obj"\n[motion]\ninertia_kg_m2 = [1, 1, 1]\n'
        "w0_T_deg_s = [0, 0, 0]\nq_CT0 = [1, 0, 0, 0]\np_CT0_m = [0, 0, 5]\n"
    )
    with pytest.raises(scene_file.SceneError, match="no model file .*none.obj"):
        scene_file.load(path)


def test_unreadable_files_and_unknown_variants_are_refused(tmp_path):
    path = tmp_path / "s.toml"
    with pytest.raises(scene_file.SceneError, match="No such file"):
        scene_file.load(path)
    path.write_text("[target\n")
    with pytest.raises(scene_file.SceneError):
        scene_file.load(path)
    with pytest.raises(scene_file.SceneError, match="no variant 'tiny'"):
        scene_file.load(SCENES / "far.toml", "tiny")


@pytest.mark.parametrize("name", STANDARD)
@pytest.mark.parametrize("variant", [None, "small"])
def test_the_standard_scenes_load_and_their_targets_stay_in_view(name, variant):
    from generator import mesh, pipeline

    scene = scene_file.load(SCENES / f"{name}.toml", variant)
    scene["target"]["texture_px"] = 64
    plan = pipeline.Plan(scene)
    parts, _, _ = pipeline.build_target(scene)
    pipeline.check_view(plan, mesh.all_vertices(parts))
    if variant:
        assert scene["camera"]["resolution"] == [640, 360] and scene["time"]["frames"] == 60


def test_a_target_out_of_view_is_refused():
    from generator import mesh, pipeline

    for place, words in (([3.0, 0, 5.0], "its middle is at pixel"), ([0, 0, 0.3], "behind the camera")):
        raw = {**_with("motion", "p_CT0_m", place), "time": {"frames": 2}}
        scene = scene_file.check(raw)
        plan = pipeline.Plan(scene)
        parts, _, _ = pipeline.build_target(scene)
        with pytest.raises(scene_file.SceneError, match=words):
            pipeline.check_view(plan, mesh.all_vertices(parts))
