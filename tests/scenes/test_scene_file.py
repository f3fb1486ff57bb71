"""What the generator refuses, and how it says so."""

from pathlib import Path

import numpy as np
import pytest
from polhode_ground.scenes import scene_file

SCENES = Path(__file__).resolve().parents[2] / "hil" / "scenes"
STANDARD = ("paper_3d", "paper_2d", "earth", "damaged", "upper_stage", "fast_tumble", "far", "spin", "still", "limb", "lab_still")

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
        (_with("camera", "attitude_history", [[0.0, 0, 0, 0, 0]]), "camera.attitude_history[0]: the quaternion must not be zero"),
        (_with("camera", "attitude_history", [[1.0, 1, 0, 0, 0], [0.0, 1, 0, 0, 0]]), "times must ascend"),
        (_with("camera", "lens_mm", 0.0), "must be positive"),
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
    from polhode_ground.scenes import mesh, pipeline

    scene = scene_file.load(SCENES / f"{name}.toml", variant)
    scene["target"]["texture_px"] = 64
    plan = pipeline.Plan(scene)
    parts, _, _ = pipeline.build_target(scene)
    pipeline.check_view(plan, mesh.all_vertices(parts))
    if variant:
        assert scene["camera"]["resolution"] == [640, 360] and scene["time"]["frames"] == 60


def _spans_px(scene):
    """Width and height of the target's projection in each frame (N, 2) [px], and the scene's plan."""
    from polhode_ground.scenes import camera, mesh, pipeline

    scene["target"]["texture_px"] = 64
    plan = pipeline.Plan(scene)
    vertices_T = mesh.all_vertices(pipeline.build_target(scene)[0]) - plan.centre_of_mass_G_m
    spans = []
    for i in range(len(plan.timestamps_ns)):
        spans.append(np.ptp(camera.project(plan.camera, vertices_T @ plan.motion.R_CT(i).T + plan.motion.p_CT_m[i]), axis=0))
    return np.array(spans), plan


def test_the_papers_body_grows_from_15_to_75_percent_of_the_height_in_50_minutes():
    scene = scene_file.load(SCENES / "paper_3d.toml")
    assert scene["motion"]["inertia_kg_m2"] == [[0.47, 0, 0], [0, 0.47, 0], [0, 0, 0.02]]
    assert scene["motion"]["w0_T_deg_s"] == [0.0, 0.1, 1.0] and scene["motion"]["v_C0_m_s"] == [0.0, 0.0, -0.0045]
    spans, plan = _spans_px(scene)
    assert len(spans) == 300 and plan.motion.time_s[1] == 10.0
    assert (plan.camera.width, plan.camera.height) == (1920, 1080) and plan.camera.fu == pytest.approx(50 / 36 * 1920)
    # The body's own height over the range; its projection leans and turns about these values.
    share = scene["target"]["size_m"] / np.linalg.norm(plan.motion.p_CT_m, axis=1) * plan.camera.fu / 1080
    assert share[0] == pytest.approx(0.15, abs=0.003) and share[-1] == pytest.approx(0.75, abs=0.015)
    assert spans[0, 1] / 1080 == pytest.approx(0.15, abs=0.003)
    assert 0.4 < spans[-36:, 1].min() / 1080 and spans[:, 1].max() < 0.9 * 1080


def test_the_other_standard_scenes_are_what_their_names_say():
    spans, plan = _spans_px(scene_file.load(SCENES / "far.toml"))
    assert np.degrees(spans.mean() / plan.camera.fu) == pytest.approx(3.0, abs=0.3)
    scene = scene_file.load(SCENES / "paper_2d.toml")
    assert scene["target"]["panel_length_m"] == 0.06 and scene["background"]["kind"] == "laboratory"
    assert scene["time"]["frames"] == 210 and scene["time"]["period_s"] == pytest.approx(1 / 30)
    plan = _spans_px(scene)[1]
    up_C = np.array(scene["background"]["up_C"])
    # About the vertical, in the plane of the table: 1e-6 is what the ten digits of the scene file leave.
    assert np.abs(plan.motion.v_C_m_s @ up_C).max() < 1e-6
    assert all(np.abs(plan.motion.R_CT(i)[:, 2] - up_C).max() < 1e-6 for i in range(0, 210, 30))
    rates_deg_s = {name: np.degrees(_spans_px(scene_file.load(SCENES / f"{name}.toml", "small"))[1].motion.w_T_rad_s)
                   for name in ("fast_tumble", "spin", "still")}
    assert np.linalg.norm(rates_deg_s["fast_tumble"], axis=1).mean() == pytest.approx(5.0, abs=0.3)
    assert np.abs(rates_deg_s["fast_tumble"]).min(axis=0).max() > 0.5
    assert np.allclose(rates_deg_s["spin"], [0, 0, 3.0]) and np.all(rates_deg_s["still"] == 0)


def test_rates_that_can_not_be_computed_are_refused_as_the_scene_that_they_are():
    from polhode_ground.scenes import pipeline

    with pytest.raises(scene_file.SceneError, match="motion.w0_T_deg_s: .* too many turns"):
        pipeline.Plan(scene_file.check(_with("motion", "w0_T_deg_s", [0, 0, 1e7])))


def test_a_target_out_of_view_is_refused():
    from polhode_ground.scenes import mesh, pipeline

    for place, words in (([3.0, 0, 5.0], "its middle is at pixel"), ([0, 0, 0.3], "behind the camera")):
        raw = {**_with("motion", "p_CT0_m", place), "time": {"frames": 2}}
        scene = scene_file.check(raw)
        plan = pipeline.Plan(scene)
        parts, _, _ = pipeline.build_target(scene)
        with pytest.raises(scene_file.SceneError, match=words):
            pipeline.check_view(plan, mesh.all_vertices(parts))


def test_a_large_window_gets_the_samples_that_a_frame_can_afford_but_three_at_least():
    from polhode_ground.scenes import pipeline

    assert pipeline.large_window_samples(16, 1, (0, 0, 640, 640)) is None
    assert pipeline.large_window_samples(16, 3, (0, 0, 640, 640)) is None
    assert pipeline.large_window_samples(16, 1, (100, 0, 650, 650)) == 10
    assert pipeline.large_window_samples(16, 1, (0, 0, 729, 892)) == 7
    assert pipeline.large_window_samples(16, 1, (0, 0, 1920, 1080)) == 3
    assert pipeline.large_window_samples(8, 3, (0, 0, 700, 750)) == 3
    assert pipeline.large_window_samples(8, 3, (0, 0, 1920, 1080)) == 1
    assert pipeline.large_window_samples(1, 1, (0, 0, 1920, 1080)) == 1


def test_the_fingerprint_tells_whether_windows_are_large():
    from polhode_ground.scenes import mesh, pipeline, scene_file

    for range_m, large in ((9.0, False), (2.5, True)):
        scene = scene_file.check({**_with("motion", "p_CT0_m", [0, 0, range_m]), "time": {"frames": 2}})
        plan = pipeline.Plan(scene)
        corners_T = mesh.all_vertices(pipeline.build_target(scene)[0]) - plan.centre_of_mass_G_m
        assert pipeline.has_large_window(plan, corners_T) == large
        assert pipeline.fingerprint(scene, True) != pipeline.fingerprint(scene, False)