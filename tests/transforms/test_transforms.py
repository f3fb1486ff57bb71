"""What each transform promises: truth that a picture can be held to, the same bytes for the same seed, a log of what was done."""

import csv
import filecmp
import json
import pathlib
import subprocess
import sys

import dotted
import numpy as np
import pytest
import trimesh
from polhode_ground.common.errors import BadInput
from polhode_ground.common.fault_log import LOG_FILE, read_log
from polhode_ground.common.sequence import read_sequence
from polhode_ground.common.tables import read_motion
from polhode_ground.judge import align
from polhode_ground.transforms.footage import read_footage
from polhode_ground.transforms.table import KINDS, options_of, transform

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
# Pictures that do not show the truth of their stamps, in the frames that the log names.
UNTRUE = {"faults", "repeated", "near_repeated", "stale", "foreign", "torn", "halves"}
# Pictures whose pixels stay, while something else is said of them.
CLAIMS = {"focal_length", "aspect", "principal_point"}


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return dotted.write(tmp_path_factory.mktemp("source") / "plate")


def made(source, tmp_path, kind, seed=3, **options):
    transform(source, tmp_path / kind, [{"kind": kind, **options}], seed)
    return tmp_path / kind


def motion_of(folder):
    return read_sequence(folder), read_motion(folder / "truth.csv"), read_log(folder / LOG_FILE)


def mirrored_dots(folder) -> np.ndarray:
    return dotted.DOTS_T * ([-1, 1, 1] if folder.name == "mirrored" else [1, 1, 1])


def errors_px(folder, frames=None) -> np.ndarray:
    """Dots in the pictures less their projections by truth.csv and sensor.yaml, in all frames that the log does not call untrue."""
    sequence, truth, log = motion_of(folder)
    untrue = dotted.spoiled(log) if folder.name in UNTRUE else set()
    row_at = {int(stamp): row for row, stamp in enumerate(truth.timestamp_ns)}
    found = []
    for index, stamp in enumerate(int(value) for value in sequence.timestamp_ns):
        if stamp in untrue or (frames is not None and index not in frames):
            continue
        row = row_at[stamp]
        expected = sequence.camera.project(align.rotations(truth.q_CT[row]).apply(mirrored_dots(folder)) + truth.p_CT[row])
        found.append(dotted.dots_px(sequence.read_gray(index), expected) - expected)
    found = np.concatenate(found)
    return found[np.isfinite(found).all(axis=1)]


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in CLAIMS | {"rolling_shutter", "zoom", "halves"}])
def test_pictures_show_the_truth_of_their_stamps(source, tmp_path, kind):
    options = {"sigma_gray": 1.0} if kind == "noise" else {"quality": 95} if kind == "jpeg" else {}
    found = errors_px(made(source, tmp_path, kind, **options))
    assert len(found) > 60, "there is something to measure"
    # Dots cut by spots, text, or a picture's end are off by more; a wrong truth is off by pixels everywhere.
    assert np.median(np.linalg.norm(found, axis=1)) < 0.1
    assert np.abs(np.median(found, axis=0)).max() < 0.05


def test_rolling_shutter_shows_each_row_at_its_own_time(source, tmp_path):
    part = 0.5
    folder = made(source, tmp_path, "rolling_shutter", readout_part=part)
    sequence, _, _ = motion_of(folder)
    off, moved = [], []
    for index in range(5, dotted.FRAMES - 1):
        time_s = index * dotted.PERIOD_S
        R_CT, p_CT = dotted.pose(time_s)
        middle = dotted.CAMERA.project(R_CT.apply(dotted.DOTS_T) + p_CT)
        expected = middle.copy()
        for _ in range(4):  # the row that a dot is in says when it is seen, and the other way round
            for i, row in enumerate(expected[:, 1]):
                R_later, p_later = dotted.pose(time_s + part * dotted.PERIOD_S * ((row + 0.5) / dotted.CAMERA.height_px - 0.5))
                expected[i] = dotted.CAMERA.project(R_later.apply(dotted.DOTS_T[i : i + 1]) + p_later)[0]
        off.append(dotted.dots_px(sequence.read_gray(index), expected) - expected)
        moved.append(expected - middle)
    off, moved = np.concatenate(off), np.concatenate(moved)
    known = np.isfinite(off).all(axis=1)
    assert known.sum() > 100 and np.linalg.norm(moved[known], axis=1).max() > 0.5, "the shutter moves dots visibly"
    assert np.linalg.norm(off[known], axis=1).max() < 0.15


@pytest.mark.parametrize(("kind", "options", "du_px", "dv_px"), [
    ("principal_point", {"du_px": 7.0, "dv_px": -3.0}, 7.0, -3.0), ("focal_length", {"factor": 1.0}, 0.0, 0.0)])
def test_a_claim_moves_projections_and_no_pixel(source, tmp_path, kind, options, du_px, dv_px):
    folder = made(source, tmp_path, kind, **options)
    for ours in (folder / "mav0/cam0/data").iterdir():
        assert filecmp.cmp(ours, source / "mav0/cam0/data" / ours.name, shallow=False)
    sequence, truth, _ = motion_of(folder)
    p_C = align.rotations(truth.q_CT[3]).apply(dotted.DOTS_T) + truth.p_CT[3]
    assert np.allclose(sequence.camera.project(p_C) - dotted.CAMERA.project(p_C), [du_px, dv_px], atol=1e-6)


def test_a_focal_length_is_stated_wrong_by_its_factor(source, tmp_path):
    sequence, _, _ = motion_of(made(source, tmp_path, "focal_length", factor=1.2))
    assert np.allclose(sequence.camera.intrinsics_px, dotted.CAMERA.intrinsics_px * [1.2, 1.2, 1, 1])


def test_a_ratio_of_pixels_is_stated_wrong_by_its_factor(source, tmp_path):
    sequence, _, _ = motion_of(made(source, tmp_path, "aspect", factor=1.2))
    assert np.allclose(sequence.camera.intrinsics_px, dotted.CAMERA.intrinsics_px * [1, 1.2, 1, 1])


def test_a_zoom_shows_each_frame_by_its_own_focal_length(source, tmp_path):
    folder = made(source, tmp_path, "zoom", factor=1.3)
    sequence, truth, _ = motion_of(folder)
    for index in (0, dotted.FRAMES // 2, dotted.FRAMES - 1):
        factor = 1.3 ** (index / (dotted.FRAMES - 1))
        stated = dotted.CAMERA.project(align.rotations(truth.q_CT[index]).apply(dotted.DOTS_T) + truth.p_CT[index])
        middle = dotted.CAMERA.intrinsics_px[2:]
        expected = middle + factor * (stated - middle)
        off = dotted.dots_px(sequence.read_gray(index), expected) - expected
        assert np.nanmedian(np.linalg.norm(off, axis=1)) < 0.1


def test_halves_are_the_frame_before_above_and_the_frame_below(source, tmp_path):
    good, (now, _, log) = read_sequence(source), motion_of(made(source, tmp_path, "halves"))
    row = dotted.CAMERA.height_px // 2
    assert len(log) == dotted.FRAMES - 1
    for index in (1, 2, dotted.FRAMES - 1):
        assert np.array_equal(now.read_gray(index)[:row], good.read_gray(index - 1)[:row])
        assert np.array_equal(now.read_gray(index)[row:], good.read_gray(index)[row:])


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_bytes(source, tmp_path, kind):
    transform(source, tmp_path / "a", [{"kind": kind}], seed=5)
    transform(source, tmp_path / "b", [{"kind": kind}], seed=5)
    files = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(tmp_path / "b") for path in (tmp_path / "b").rglob("*") if path.is_file())
    assert all((tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes() for file in files)


@pytest.mark.parametrize("kind", KINDS)
def test_every_change_is_logged_and_the_source_stays(source, tmp_path, kind):
    before = {path: path.read_bytes() for path in source.rglob("*") if path.is_file()}
    folder = made(source, tmp_path, kind)
    assert {path: path.read_bytes() for path in source.rglob("*") if path.is_file()} == before
    log = read_log(folder / LOG_FILE)
    assert log and all(one.detail for one in log)
    stamps = {int(shot.timestamp_ns) for shot in read_footage(source).shots}
    assert {one.timestamp_ns for one in log} <= stamps


@pytest.mark.parametrize(("kind", "fraction"), [("repeated", 0.2), ("stale", 0.2), ("torn", 0.2), ("foreign", 0.2), ("missing", 0.2)])
def test_the_fraction_asked_for_is_spoiled(source, tmp_path, kind, fraction):
    options = {"age_frames": 5} if kind == "stale" else {}
    log = read_log(made(source, tmp_path, kind, fraction=fraction, **options) / LOG_FILE)
    assert len(log) == round(fraction * dotted.FRAMES)


def test_missing_frames_come_in_runs_and_are_gone_from_the_list(source, tmp_path):
    folder = made(source, tmp_path, "missing", fraction=0.25, run_frames=5)
    sequence, _, log = motion_of(folder)
    assert len(sequence.timestamp_ns) == dotted.FRAMES - len(log) and len(log) == 10
    gaps = np.diff(sequence.timestamp_ns) / (1e9 * dotted.PERIOD_S)
    assert set(np.rint(gaps).astype(int)) <= {1, 6, 11}


def test_an_excerpt_is_the_same_frames_from_a_later_one_on(source, tmp_path):
    good, (now, _, log) = read_sequence(source), motion_of(made(source, tmp_path, "excerpt", first_frame=7, frames=12))
    assert list(now.timestamp_ns) == list(good.timestamp_ns[7:19]) and len(log) == dotted.FRAMES - 12
    assert all(now.frame_path(k).read_bytes() == good.frame_path(7 + k).read_bytes() for k in range(12))


def test_an_excerpt_ends_with_the_sequence_and_has_two_frames_at_least(source, tmp_path):
    now, _, _ = motion_of(made(source, tmp_path, "excerpt", first_frame=dotted.FRAMES - 2, frames=12))
    assert len(now.timestamp_ns) == 2
    with pytest.raises(BadInput, match=f"first_frame = {dotted.FRAMES - 1}: the sequence has {dotted.FRAMES} frames only"):
        made(source, tmp_path / "short", "excerpt", first_frame=dotted.FRAMES - 1)


def test_stale_and_repeated_pictures_are_old_ones(source, tmp_path):
    for kind, age in (("repeated", None), ("stale", 7)):
        folder = made(source, tmp_path, kind, **({"age_frames": age} if age else {}))
        good, (now, _, log) = read_sequence(source), motion_of(folder)
        for one in log:
            picture = now.read_gray(one.frame)
            old = now.read_gray(one.frame - 1) if age is None else good.read_gray(one.frame - age)
            assert np.array_equal(picture, old) and not np.array_equal(picture, good.read_gray(one.frame))


def test_a_jump_of_the_rate_multiplies_rates_and_velocities(source, tmp_path):
    _, truth, log = motion_of(made(source, tmp_path, "rate_jump", factor=2, at_part=0.5))
    at = log[0].frame
    speed = np.linalg.norm(truth.w_T, axis=1)
    assert np.allclose(speed[:at], dotted.RATE_RAD_S) and np.allclose(speed[at:], 2 * dotted.RATE_RAD_S)
    assert np.allclose(truth.v_C[at:], 2 * truth.v_C[0])
    turn = (align.rotations(truth.q_CT[1:]) * align.rotations(truth.q_CT[:-1]).inv()).magnitude() / dotted.PERIOD_S
    assert np.allclose(turn[at:], 2 * dotted.RATE_RAD_S, atol=1e-6), "attitudes are those of the rates"


def test_backwards_means_backwards(source, tmp_path):
    _, truth, log = motion_of(made(source, tmp_path, "rate_jump", factor=-1, at_part=0.6))
    assert np.allclose(truth.w_T[log[0].frame :, 2], -dotted.RATE_RAD_S)


def test_wrong_stamps_move_with_their_poses_and_leave_the_rates(source, tmp_path):
    before, (sequence, truth, _) = read_motion(source / "truth.csv"), motion_of(made(source, tmp_path, "stamps", pace=1.1))
    assert np.allclose(np.diff(sequence.timestamp_ns), 1.1e9 * dotted.PERIOD_S, atol=2)
    assert np.allclose(truth.q_CT, before.q_CT) and np.allclose(truth.w_T, before.w_T)


def test_a_mirrored_scene_is_a_consistent_one(source, tmp_path):
    """Rates of the mirrored truth are the derivative of its attitudes; the mesh is mirrored with it."""
    folder = made(source, tmp_path, "mirrored")
    _, truth, _ = motion_of(folder)
    R_CT = align.rotations(truth.q_CT)
    step = (R_CT[:-1].inv() * R_CT[1:]).as_rotvec() / dotted.PERIOD_S
    assert np.allclose(step, truth.w_T[:-1], atol=1e-6)
    assert np.allclose(np.diff(truth.p_CT, axis=0) / dotted.PERIOD_S, truth.v_C[:-1], atol=1e-6)
    ours, theirs = trimesh.load(folder / "model.ply", process=False), trimesh.load(source / "model.ply", process=False)
    assert np.allclose(np.sort(ours.vertices[:, 0]), np.sort(-theirs.vertices[:, 0])) and ours.volume == pytest.approx(theirs.volume)
    inertia = np.array(json.loads((folder / "scene.json").read_text())["scene"]["motion"]["inertia_kg_m2"])
    assert inertia[0, 1] == -0.1 and inertia[1, 1] == 1.2


def test_a_target_that_leaves_is_out_of_sight_and_the_servicer_knows_the_turn(source, tmp_path):
    folder = made(source, tmp_path, "leaving", from_part=0.4, to_part=0.7)
    sequence, truth, log = motion_of(folder)
    gone = {one.frame for one in log}
    assert len(gone) >= 8
    for frame in range(dotted.FRAMES):
        p_C = align.rotations(truth.q_CT[frame]).apply(dotted.DOTS_T) + truth.p_CT[frame]
        u = sequence.camera.project(p_C)[:, 0]
        inside = (u >= 0) & (u < sequence.camera.width_px)
        assert not inside.any() if frame in gone else True
    with open(folder / "servicer_attitude.csv") as stream:
        rows = [[float(cell) for cell in row[1:]] for row in list(csv.reader(stream))[1:]]
    # In inertial axes the body turns as before: the camera's own turn is taken out by what the servicer knows.
    before = align.rotations(read_motion(source / "truth.csv").q_CT)
    assert np.allclose((align.rotations(np.array(rows)) * align.rotations(truth.q_CT) * before.inv()).magnitude(), 0, atol=1e-6)


def test_steps_are_done_one_after_the_other(source, tmp_path):
    transform(source, tmp_path / "both", [{"kind": "mirrored"}, {"kind": "missing", "fraction": 0.1}], seed=2)
    sequence, _, log = motion_of(tmp_path / "both")
    assert len(sequence.timestamp_ns) == dotted.FRAMES - 4 and {one.kind for one in log} == {"mirrored", "missing"}


def test_a_picture_that_nothing_changes_is_a_copy(source, tmp_path):
    folder = made(source, tmp_path, "missing")
    for ours in (folder / "mav0/cam0/data").iterdir():
        theirs = source / "mav0/cam0/data" / ours.name
        assert ours.read_bytes() == theirs.read_bytes() and not ours.samefile(theirs)


def test_a_shutter_after_a_mirror_moves_by_the_mirrored_mesh(source, tmp_path):
    """Mirrored first or last, columns apart it is the same picture."""
    shutter = {"kind": "rolling_shutter", "readout_part": 0.5}
    transform(source, tmp_path / "first", [{"kind": "mirrored"}, shutter], seed=2)
    transform(source, tmp_path / "last", [shutter, {"kind": "mirrored"}], seed=1)
    for index in (8, 20):
        first, last = (read_sequence(tmp_path / name).read_gray(index).astype(int) for name in ("first", "last"))
        assert np.abs(first - last).max() <= 12, "samples of the mesh are not the same"


def test_what_restamps_comes_first(source, tmp_path):
    with pytest.raises(BadInput, match="stamps gives frames other times: it must be the first step"):
        transform(source, tmp_path / "out", [{"kind": "faults"}, {"kind": "stamps"}], seed=1)
    transform(source, tmp_path / "out", [{"kind": "stamps"}, {"kind": "torn"}], seed=1)
    delivered = {int(stamp) for stamp in read_sequence(tmp_path / "out").timestamp_ns}
    assert {one.timestamp_ns for one in read_log(tmp_path / "out" / LOG_FILE)} <= delivered


def test_the_ends_of_ranges_are_taken_or_refused_in_words(source, tmp_path):
    assert not read_log(made(source, tmp_path, "missing", fraction=0.0) / LOG_FILE)
    _, truth, _ = motion_of(made(source, tmp_path, "rate_jump", at_part=1.0))
    assert len(truth.timestamp_ns) == dotted.FRAMES
    with pytest.raises(BadInput, match="the sequence has 40 frames only"):
        made(source, tmp_path, "stale", age_frames=200)
    sequence, _, _ = motion_of(made(source, tmp_path, "stamps", pace=1.0, jitter_part=0.5))
    assert int(sequence.timestamp_ns[0]) == dotted.START_NS


@pytest.mark.parametrize(("kind", "given", "says"), [
    ("blur", {}, "kind 'blur' is none of faults"), ("jpeg", {"sharpness": 3}, "jpeg has no option 'sharpness'; allowed: quality"),
    ("jpeg", {"quality": 101}, "quality = 101: allowed is a whole number in 1 .. 100"), ("jpeg", {"quality": 50.5}, "whole number"),
    ("noise", {"sigma_gray": "much"}, "allowed is a number"), ("noise", {"sigma_gray": True}, "allowed is a number"),
    ("noise", {"sigma_gray": float("nan")}, "allowed is a number"), ("rate_jump", {"factor": 0}, "other than 0"),
    ("mirrored", {"axis": 1}, "allowed: none")])
def test_options_are_refused_in_words(kind, given, says):
    with pytest.raises(BadInput, match="here: ") as refused:
        options_of("here", kind, given)
    assert says in str(refused.value)


def test_the_command_lists_every_kind_and_makes_one(source, tmp_path):
    command = [sys.executable, REPOSITORY / "hil/transform.py"]
    listed = subprocess.run([*command, "--list"], capture_output=True, text=True, timeout=60)
    assert listed.returncode == 0 and all(f"{kind}: " in listed.stdout for kind in KINDS)
    done = subprocess.run([*command, source, tmp_path / "out", "--kind", "missing", "--set", "missing.fraction=0.5"],
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert len(read_log(tmp_path / "out" / LOG_FILE)) == 20
