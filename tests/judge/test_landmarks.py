"""Landmarks on the background, counted on a made-up body: those of the final map, by where they were seen."""

import pytest
from polhode_ground.common.sequence import read_sequence
from polhode_ground.judge.landmarks import on_background
from polhode_ground.judge.shape import read_landmark_numbers
from polhode_ground.testing.synthetic import HEIGHT_PX, project, tumbling_body, write_sequence

FRAMES = range(6)


@pytest.fixture(scope="module")
def body():
    return tumbling_body()


@pytest.fixture(scope="module")
def sequence(tmp_path_factory, body):
    return read_sequence(write_sequence(tmp_path_factory.mktemp("scene") / "seq", body))


def write_map(folder, body, landmarks: dict[int, tuple[bool, list[int]]], final: list[int] | None):
    """A run that saw each landmark, on the body's middle or beside the body, in the frames given."""
    rows = ["frame,timestamp_ns,landmark,u_px,v_px,predicted_u_px,predicted_v_px,inlier"]
    for number, (on_body, frames) in landmarks.items():
        for frame in frames:
            u, v = project(body.p_CT[frame][None])[0] if on_body else (2.0, HEIGHT_PX - 3.0)
            rows.append(f"{frame},{body.timestamp_ns[frame]},{number},{u:.2f},{v:.2f},{u:.2f},{v:.2f},1")
    (folder / "observations.csv").write_text("\n".join(rows) + "\n")
    numbers = [] if final is None else final
    header = ["ply", "format ascii 1.0", f"element vertex {len(numbers)}", *(f"property float {a}" for a in "xyz")]
    header += ["property int landmark"] if final is not None else []
    points = [f"0 0 {k} {number}" for k, number in enumerate(numbers)]
    (folder / "cloud_raw.ply").write_text("\n".join([*header, "end_header", *points]) + "\n")
    return folder


def test_landmarks_of_the_final_map_are_judged(tmp_path, body, sequence):
    landmarks = {n: (True, list(FRAMES)) for n in range(5)} | {7: (False, list(FRAMES)), 9: (False, [0, 1])}
    run = write_map(tmp_path, body, landmarks, final=[0, 1, 2, 7, 9])
    assert on_background(run, sequence) == (2, 5)


def test_a_landmark_that_was_dropped_does_no_harm(tmp_path, body, sequence):
    landmarks = {0: (True, list(FRAMES)), 7: (False, list(FRAMES))}
    assert on_background(write_map(tmp_path, body, landmarks, final=[0]), sequence) == (0, 1)


def test_without_numbers_all_seen_three_times_count(tmp_path, body, sequence):
    landmarks = {0: (True, list(FRAMES)), 7: (False, list(FRAMES)), 9: (False, [0, 1])}
    assert on_background(write_map(tmp_path, body, landmarks, final=None), sequence) == (1, 2)


def test_numbers_are_read_from_the_cloud(tmp_path, body):
    run = write_map(tmp_path, body, {}, final=[3, 14, 15])
    assert read_landmark_numbers(run / "cloud_raw.ply") == {3, 14, 15}
