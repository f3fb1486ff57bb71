"""Pictures of two cameras are not taken for those of one; distances are no pictures; what was recorded twice counts once."""

import made_sources as sources
import numpy as np
import pytest
from made_sources import NS
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.plan import Part, Plan
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Options

COUNT = 8
START = 1_700_000_000 * NS
STORE = sources.ros_types(1)
MATRIX = [[80, 0, 31.5], [0, 80, 23.5], [0, 0, 1]]


def picture(index: int) -> np.ndarray:
    return np.full((48, 64), 20 * index, np.uint8)


def image(index: int, frame_id="left", later_ns=0, **more):
    message = sources.image_message(STORE, picture(index), START + index * NS // 10 + later_ns, **more)
    message.header.frame_id = frame_id
    return message


def bag(path, *messages):
    """(topic, message): received 5 ms after one another."""
    sources.write_bag(path, 1, [(topic, START + place * 5_000_000, message) for place, (topic, message) in enumerate(messages)])
    return path


def read(path, **options):
    """(first levels, the source with what is said) of all frames."""
    source = open_source(path, Options(**options))
    return [int(frame.pixels[0, 0]) // 20 for frame in Plan(source, Part()).frames()], source


# verifies: GND-03
def test_two_cameras_in_one_topic_are_told_apart_by_their_frame(tmp_path):
    pairs = [("/images", image(index, side, later)) for index in range(COUNT) for side, later in (("left", 0), ("right", 7_000_000))]
    with pytest.raises(BadInput, match=r"2 cameras by turns, by their frame_id: left \(8\), right \(8\); choose one by --camera left"):
        read(bag(tmp_path / "two.bag", *pairs))
    found, source = read(tmp_path / "two.bag", camera="right")
    assert found == list(range(COUNT)) and source.times_ns[0] == START + 7_000_000 and source.account.dropped == {"taken by another camera": COUNT}


def test_a_camera_that_is_renamed_once_stays_one(tmp_path):
    found, source = read(bag(tmp_path / "one.bag", *[("/images", image(index, "new" if index > 3 else "old")) for index in range(COUNT)]))
    assert found == list(range(COUNT)) and "the frame_id changes, old (4), new (4)" in source.account.assumed[0]


def test_the_calibration_is_that_of_the_pictures_camera(tmp_path):
    def infos(*names):
        for name in names:
            message = sources.info_message(STORE, 64, 48, np.multiply(MATRIX, 2 if name == "other" else 1), [0] * 5)
            message.header.frame_id = name
            yield "/cam/camera_info", message
    pictures = [("/cam/image_raw", image(index)) for index in range(COUNT)]
    _, source = read(bag(tmp_path / "a.bag", *infos("other", "left"), *pictures))
    assert source.lens.intrinsics_px[0] == 80 and not source.account.assumed
    _, source = read(bag(tmp_path / "b.bag", *infos("other", "third"), *pictures))
    assert source.lens is None and "of several cameras (other, third), and the pictures are of 'left'" in source.account.no_lens


def test_distances_are_no_pictures(tmp_path):
    light = [("/d/color/image_raw", image(index)) for index in range(COUNT)]
    deep = []
    for topic, message in light:
        distances = sources.image_message(STORE, np.full((48, 64), 900, np.uint16), START + NS, "16UC1")
        deep.append(("/d/depth/image_rect_raw", distances))
    found, source = read(bag(tmp_path / "both.bag", *light, *deep))
    assert found == list(range(COUNT)) and source.account.assumed == ["topics of distances are left out: /d/depth/image_rect_raw"]
    with pytest.raises(BadInput, match="holds distances, allowed are pictures of light; --topic /d/depth/image_rect_raw takes it all the same"):
        read(bag(tmp_path / "deep.bag", *deep))
    assert "holds distances, not light" in read(tmp_path / "deep.bag", topic="/d/depth/image_rect_raw")[1].account.assumed[0]
    beside = bag(tmp_path / "beside.bag", *[("/depth_camera/image_raw", message) for _, message in light])  # its picture of light
    assert read(beside)[0] == list(range(COUNT))


@pytest.mark.parametrize("order", [[0, 0, 1, 1, 2, 2, 3, 3], [0, 1, 2, 3, 0, 1, 2, 3]])
def test_what_was_recorded_twice_counts_once(tmp_path, order):
    found, source = read(bag(tmp_path / "a.bag", *[("/images", image(index)) for index in order]))
    assert found == [0, 1, 2, 3] and source.account.dropped == {"recorded twice: the same picture with the same stamp": 4}


def test_equal_pictures_without_stamps_are_all_taken(tmp_path):
    messages = [("/images", sources.image_message(STORE, picture(3), 0)) for _ in range(COUNT)]
    assert len(read(bag(tmp_path / "a.bag", *messages))[0]) == COUNT
