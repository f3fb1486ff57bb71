"""Random paths: what is drawn is where the truth says, whatever the pose, and the same numbers give the same octets."""

import hashlib
import pathlib

import numpy as np
import pytest
from polhode_ground.campaigns.book import open_book
from polhode_ground.campaigns.plan import read_plan
from polhode_ground.campaigns.store import Store
from polhode_ground.campaigns.tasks import perform
from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import Camera, read_sequence
from polhode_ground.paths.boxes import Box, picture
from polhode_ground.paths.draw import draw_path, random_path
from polhode_ground.paths.flight import random_flight
from scipy.spatial.transform import Rotation

CAMERA = Camera(160, 120, np.array([200.0, 200.0, 79.5, 59.5]), np.zeros(4))
BLACK = np.zeros((120, 160))
LIGHT_C = np.array([0.0, 0.0, -1.0])


def white_box(half_m=0.3):
    return Box(np.zeros(3), np.full(3, half_m), np.ones((6, 112, 112)))


@pytest.mark.parametrize("seed", range(5))
def test_a_body_is_where_its_pose_puts_it(seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    p_C = np.array([rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3), rng.uniform(3, 6)])
    seen = picture([white_box(0.02)], CAMERA, q / np.linalg.norm(q), p_C, LIGHT_C, BLACK)
    v, u = np.mgrid[0:120, 0:160]
    found = np.array([(seen * u).sum(), (seen * v).sum()]) / seen.sum()
    assert found == pytest.approx(CAMERA.project(p_C[None])[0], abs=0.5)


def test_of_two_boxes_the_nearer_one_is_seen():
    dark = Box(np.array([0.0, 0.0, -1.0]), np.full(3, 0.1), np.zeros((6, 112, 112)))
    for body in ([dark, white_box()], [white_box(), dark]):
        seen = picture(body, CAMERA, np.array([1.0, 0, 0, 0]), np.array([0, 0, 4.0]), LIGHT_C, BLACK)
        assert seen[60, 80] < 0.01 < 0.5 < seen[60, 80 + 12]


@pytest.mark.parametrize("p_C", [[0, 0, 0], [0, 0, 0.31], [0.31, 0, 0.01], [0, 0, -3], [9, 9, 1], [0, 0, 1e6]])
def test_no_pose_is_too_much(p_C):
    seen = picture([white_box()], CAMERA, np.array([0.5, 0.5, 0.5, 0.5]), np.array(p_C, dtype=float), LIGHT_C, BLACK)
    assert np.isfinite(seen).all() and 0 <= seen.min() <= seen.max() <= 1.001
    assert (seen.max() > 0) == (p_C[2] in (0, 0.31, 0.01))


@pytest.mark.parametrize("seed", range(8))
def test_a_flight_turns_freely_between_its_contacts(seed):
    """Its rates are those of its attitudes."""
    flight = random_flight(np.random.default_rng(seed), 40, 0.2)
    R_IT = Rotation.from_quat(flight.q_IC, scalar_first=True) * Rotation.from_quat(flight.q_CT, scalar_first=True)
    step_s = flight.seconds[1]
    turned_T = (R_IT[:-1].inv() * R_IT[1:]).as_rotvec() / step_s
    between = 0.5 * (flight.w_T[:-1] + flight.w_T[1:])
    free = [i for i in range(39) if i + 1 not in flight.contacts and np.linalg.norm(between[i]) * step_s < 0.2]
    assert np.linalg.norm(turned_T - between, axis=1)[free] == pytest.approx(0, abs=0.02 * np.abs(between).max() + 1e-12)


def octets_of(folder: pathlib.Path) -> str:
    total = hashlib.sha256()
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            total.update(file.relative_to(folder).as_posix().encode() + file.read_bytes())
    return total.hexdigest()


@pytest.mark.parametrize("number", range(3))
def test_the_same_path_is_the_same_octets(tmp_path, number):
    for name in ("one", "two"):
        draw_path([3, number], 10, (96, 72), tmp_path / name)
    assert octets_of(tmp_path / "one") == octets_of(tmp_path / "two")
    assert 5 <= len(read_sequence(tmp_path / "one").filenames) <= 10


def test_every_path_can_be_drawn(tmp_path):
    """Its transforms take the options that are drawn for them."""
    kinds = set()
    for number in range(60):
        draw_path([4, number], 24, (32, 32), tmp_path / str(number))
        kinds |= {step["kind"] for step in random_path([4, number], 24, (32, 32))[1]}
    assert len(kinds) >= 15


def test_a_plan_draws_them(tmp_path):
    (tmp_path / "plan.toml").write_text("[paths]\ndraws = 2\nseed = 5\nframes = 8\nresolution = [64, 48]\n")
    (tmp_path / "program").write_text("the program")
    chains = open_book(read_plan(tmp_path / "plan.toml"), Store(tmp_path / "out", tmp_path / "cache"), tmp_path / "program")
    assert [[task.kind for task in chain.tasks] for chain in chains] == [["draw", "replay", "judge"]] * 2
    draw = chains[0].tasks[0]
    (draw.place / "mav0").mkdir(parents=True)  # as an interrupted worker leaves it
    done = perform(draw)
    assert done.ok, done.why
    assert len(read_sequence(draw.place).filenames) > 2 and chains[0].missing[0].kind == "replay"
    with pytest.raises(BadInput, match="paths.draws"):
        (tmp_path / "plan.toml").write_text("[paths]\ndraws = 0\nseed = 5\n")
        read_plan(tmp_path / "plan.toml")
