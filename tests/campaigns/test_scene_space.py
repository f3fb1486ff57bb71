"""Draws cover their ranges, more draws begin with the same ones, and every draw is a scene that renders."""

import itertools
import tomllib

import numpy as np
import pytest
from polhode_ground.campaigns.plan import scene_toml
from polhode_ground.campaigns.scene_space import BODY_RADIUS, SPACE, Choice, Picture, Range, narrowed, points, scene_of
from polhode_ground.common.errors import BadInput
from polhode_ground.scenes import mesh, pipeline, scene_file

SEEDS = (1, 36, 77)
# What the room of a laboratory decides for itself.
DECIDED_BY_THE_ROOM = {"body", "view_deg", "camera"}


def scenes(seed, draws=24):
    return [scene_of(point, Picture(), f"draw_{i}", i) for i, point in enumerate(points(dict(SPACE), draws, seed))]


@pytest.mark.parametrize("seed", SEEDS)
def test_twenty_draws_cover_every_range(seed):
    drawn = points(dict(SPACE), 20, seed)
    for name, dimension in SPACE.items():
        if name in DECIDED_BY_THE_ROOM:
            continue
        values = [point[name] for point in drawn]
        if isinstance(dimension, Range):
            quarter = np.array([dimension.at(u) for u in (0.25, 0.5, 0.75)])
            assert set(np.searchsorted(quarter, values)) == {0, 1, 2, 3}, name
            assert min(values) >= dimension.least and max(values) <= dimension.most
        else:
            shares = {choice: weight / sum(dimension.weights.values()) for choice, weight in dimension.weights.items()}
            # The first 16 points have one in each sixteenth: at least floor(16 w) - 1 of a choice of weight w.
            assert all(values.count(choice) >= int(16 * share) - 1 for choice, share in shares.items()), name


def test_a_new_dimension_leaves_the_draws_as_they_are():
    more = dict(SPACE) | {"new": Range(0, 1)}
    for point, before in zip(points(more, 24, 36), points(dict(SPACE), 24, 36)):
        assert {name: point[name] for name in SPACE} == before and 0 <= point["new"] <= 1


@pytest.mark.parametrize("seed", SEEDS)
def test_more_draws_begin_with_the_same_ones(seed):
    many = points(dict(SPACE), 50, seed)
    assert points(dict(SPACE), 24, seed) == many[:24] and points(dict(SPACE), 1, seed) == many[:1]
    assert points(dict(SPACE), 24, seed + 1) != many[:24]


def test_narrowing_one_range_leaves_the_others():
    narrow = points(narrowed("scenes.space", {"turn_deg": [1.0, 2.0], "background": "none", "size_px": 120}), 16, 36)
    for point, before in zip(narrow, points(dict(SPACE), 16, 36)):
        assert 1.0 <= point["turn_deg"] <= 2.0 and point["background"] == "none" and point["size_px"] == pytest.approx(120)
        assert point["phase_deg"] == before["phase_deg"] and point["exposure"] == before["exposure"]


@pytest.mark.parametrize("seed", SEEDS)
def test_every_draw_is_a_scene_that_renders_alone(seed, tmp_path):
    for number, scene in enumerate(scenes(seed)):
        path = tmp_path / f"{number}.toml"
        path.write_text(scene_toml(scene))
        assert tomllib.loads(path.read_text()) == scene
        checked = scene_file.load(path)
        plan = pipeline.Plan(checked)
        size = scene["target"]["size_m"]
        radius = BODY_RADIUS[scene["target"]["kind"]] * size
        directions = np.array(list(itertools.product((-1, 0, 1), repeat=3)))
        sphere_G = radius * directions / np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1)
        pipeline.check_view(plan, sphere_G)  # before the camera, its middle in the picture, in every frame


@pytest.mark.parametrize("kind", [kind for kind in BODY_RADIUS if kind != "box"])
def test_a_body_is_no_larger_than_its_sphere(kind):
    for detail_seed in (1, 500_000, 999_999):
        settings = {"kind": kind, "size_m": 2.0, "detail_seed": detail_seed, "texture_px": 64, "panel_length_m": None, "fiducials_G_m": []}
        vertices = mesh.all_vertices(pipeline.build_target({"target": settings})[0])
        middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        assert np.linalg.norm(vertices - middle, axis=1).max() <= 2.0 * BODY_RADIUS[kind]


def test_motion_is_what_was_drawn():
    for point, scene in zip(points(dict(SPACE), 24, 36), scenes(36)):
        rate = np.linalg.norm(scene["motion"]["w0_T_deg_s"])
        if point["motion"] == "still":
            assert rate == 0
            continue
        assert rate * scene["time"]["period_s"] == pytest.approx(point["turn_deg"], rel=1e-6)
        inertia = np.array(scene["motion"]["inertia_kg_m2"])
        moments, axes = np.linalg.eigh(inertia)
        assert moments[0] > 0 and moments[2] < moments[0] + moments[1], "a body with mass everywhere"
        angle = np.degrees(np.arccos(min(1.0, abs(axes[:, 2] @ scene["motion"]["w0_T_deg_s"]) / rate)))
        assert angle == pytest.approx(point["tilt_deg"] if point["motion"] == "tumble" else 0.0, abs=1e-4)


@pytest.mark.parametrize(("given", "says"), [
    ({"colour": 1}, "colour: no such dimension; there are: body, detail"),
    ({"turn_deg": [2, 1]}, "allowed is a number, or [least, most]"), ({"turn_deg": [0, 1]}, "must be positive"),
    ({"turn_deg": "fast"}, "allowed is a number"), ({"body": "sphere"}, "allowed is one of cubesat, damaged_cube, upper_stage, box"),
    ({"body": {"cubesat": 0}}, "weights"), ({"body": {"cubesat": -1, "box": 2}}, "weights")])
def test_what_is_no_space_is_refused(given, says):
    with pytest.raises(BadInput) as refused:
        narrowed("scenes.space", given)
    assert says in str(refused.value)


def test_a_choice_follows_its_weights():
    choice = Choice({"a": 1.0, "b": 3.0})
    values = [choice.at(u) for u in (np.arange(100) + 0.5) / 100]
    assert values.count("a") == 25 and choice.at(0.0) == "a" and choice.at(1.0) == "b"
