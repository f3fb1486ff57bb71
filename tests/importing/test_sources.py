"""Each kind of source comes out as the frames that went in, at their times; what was dropped and assumed is said."""

import json
import subprocess
import sys

import made_sources as sources
import numpy as np
import pytest
from made_sources import INTRINSICS, REPOSITORY, SAMPLE
from PIL import Image

NS = sources.NS
COUNT = 6


@pytest.fixture(scope="module")
def frames(sample):
    return [sample.read_gray(index) for index in range(COUNT)]


def same(sequence, frames) -> bool:
    return len(sequence.filenames) == len(frames) and all(np.array_equal(sequence.read_gray(i), pixels) for i, pixels in enumerate(frames))


# verifies: GND-03
def test_a_video_keeps_its_own_times_and_nearly_its_pixels(imported, frames, tmp_path):
    times_s = [0.5, 0.54, 0.6, 0.7, 0.75, 1.0]  # a variable rate
    sources.write_video(tmp_path / "clip.mp4", frames, times_s)
    sequence, out = imported(tmp_path / "clip.mp4", "--intrinsics", INTRINSICS)
    assert sequence.timestamp_ns.tolist() == [round(time * 1000) * 1_000_000 for time in times_s]
    for index, pixels in enumerate(frames):
        assert np.abs(sequence.read_gray(index).astype(int) - pixels).mean() < 1.5  # limited range and H.264 round
    assert "read: " in out and "h264, 640x480" in out and "presentation time" in out


def test_a_video_is_cropped_in_time_and_thinned(imported, frames, tmp_path):
    sources.write_video(tmp_path / "clip.mp4", frames, [0, 1, 2, 3, 4, 5])
    sequence, out = imported(tmp_path / "clip.mp4", "--intrinsics", INTRINSICS, "--from", 1, "--to", 4, "--step", 2)
    assert sequence.timestamp_ns.tolist() == [1 * NS, 3 * NS]
    assert "dropped: 1 frames: before --from" in out and "dropped: 2 frames: by --step" in out


@pytest.mark.parametrize("rotation_deg", [90, 180, 270])
def test_a_video_is_turned_as_players_turn_it(imported, tmp_path, rotation_deg):
    picture = np.full((96, 128), 40, np.uint8)
    picture[:32, :32] = 220  # bright at the top left as stored
    sources.write_video(tmp_path / "clip.mp4", [picture] * 2, [0, 1], rotation_deg)
    sequence, out = imported(tmp_path / "clip.mp4", "--intrinsics", "100,100,47.5,63.5")
    seen = sequence.read_gray(0)
    # The matrix turns clockwise by that angle: the bright corner goes to the right, then down, then left.
    expected = np.rot90(picture, -rotation_deg // 90)
    assert seen.shape == expected.shape and np.abs(seen.astype(int) - expected).mean() < 3
    assert "rotation flag" in out


def test_names_that_are_nanoseconds_are_the_times(imported, frames, tmp_path):
    names = [f"{1700000000000000000 + i * NS}.png" for i in range(COUNT)]
    sources.write_pictures(tmp_path / "photos", frames, names)
    sequence, _ = imported(tmp_path / "photos", "--intrinsics", INTRINSICS)
    assert sequence.timestamp_ns.tolist() == [int(name[:-4]) for name in names] and same(sequence, frames)


def test_numbered_pictures_are_in_order_of_their_numbers(imported, frames, tmp_path):
    sources.write_pictures(tmp_path / "photos", frames, [f"img_{i}.png" for i in (1, 2, 3, 9, 10, 11)])
    sequence, out = imported(tmp_path / "photos", "--intrinsics", INTRINSICS)
    assert sequence.timestamp_ns.tolist() == [i * NS for i in (0, 1, 2, 8, 9, 10)] and same(sequence, frames)
    assert "one picture a second is assumed" in out and "jump from img_3.png to img_9.png: 5 pictures are missing, the times keep the gaps" in out
    assert json.loads((sequence.folder / "import.json").read_text())["nominal_time"] is True
    other, out = imported(tmp_path / "photos", "--intrinsics", INTRINSICS, "--rate-hz", 4, name="SEQ4")
    assert other.timestamp_ns[1] == NS // 4 and "0.25 s apart" in out


def test_exif_gives_time_focal_length_and_orientation(imported, frames, tmp_path):
    def exif(index):
        return sources.exif_of(f"2024:05:01 10:00:0{index // 2}.{5 * (index % 2)}", focal_35mm=48, orientation=6)
    sources.write_pictures(tmp_path / "photos", frames, [f"IMG_{i:04d}.jpg" for i in range(COUNT)], exif)
    sequence, out = imported(tmp_path / "photos")
    assert np.diff(sequence.timestamp_ns).tolist() == [NS // 2] * (COUNT - 1)
    assert (sequence.camera.width_px, sequence.camera.height_px) == (480, 640)
    assert np.allclose(sequence.camera.intrinsics_px, [48 / 43.27 * 800] * 2 + [239.5, 319.5])
    shown = np.rot90(np.asarray(Image.open(tmp_path / "photos/IMG_0000.jpg")), -1)
    assert np.array_equal(sequence.read_gray(0), shown)
    assert "48 mm equivalent" in out and "--intrinsics auto is better" in out


def test_exif_times_that_repeat_are_not_used(imported, frames, tmp_path):
    sources.write_pictures(tmp_path / "photos", frames, [f"{i}.jpg" for i in range(COUNT)], lambda _: sources.exif_of("2024:05:01 10:00:00.0"))
    _, out = imported(tmp_path / "photos", "--intrinsics", INTRINSICS)
    assert "EXIF's times repeat, run back or are missing" in out


def test_files_of_16_bits_and_other_sizes(imported, tmp_path):
    (tmp_path / "photos").mkdir()
    deep = np.arange(120 * 160, dtype=np.uint16).reshape(120, 160)
    Image.fromarray(deep).save(tmp_path / "photos/1.tif")
    Image.fromarray(deep).save(tmp_path / "photos/2.png")
    Image.fromarray(deep[:60].copy()).save(tmp_path / "photos/3.png")
    (tmp_path / "photos/4.png").write_bytes(b"\x89PNG torn")
    sequence, out = imported(tmp_path / "photos", "--intrinsics", "200,200,79.5,59.5", "--allow-loss")
    assert len(sequence.filenames) == 2
    for index in range(2):
        assert np.array_equal(np.asarray(Image.open(sequence.frame_path(index))), deep)
    assert "1 frames: another size than 160x120" in out and "1 frames: picture can't be read" in out


# verifies: GND-03
def test_tum(imported, refused, frames, tmp_path):
    sources.write_pictures(tmp_path / "tum/rgb", frames, [f"{i}.png" for i in range(COUNT)])
    lines = ["# color images", *(f"1305031102.{i}75304 rgb/{i}.png" for i in range(COUNT)), "1305031103.5 rgb/gone.png"]
    (tmp_path / "tum/rgb.txt").write_text("\n".join(lines))
    (tmp_path / "tum/groundtruth.txt").write_text("# nothing")
    assert "tells no intrinsics" in refused(tmp_path / "tum")
    sequence, out = imported(tmp_path / "tum", "--intrinsics", INTRINSICS)
    assert sequence.timestamp_ns[0] == 1305031102075304000 and same(sequence, frames)
    assert "the file is missing" in out and "groundtruth.txt is left out" in out


# verifies: GND-03
def test_euroc_in_the_wild(imported, frames, tmp_path):
    """OpenCV's first line, radtan by its short name, more columns, a repeated time, a file that is not there, cam1 named."""
    sources.write_pictures(tmp_path / "wild/mav0/cam1/data", frames, [f"{100 + i}000000.png" for i in range(COUNT)])
    (tmp_path / "wild/mav0/cam1/sensor.yaml").write_text(
        "%YAML:1.0\n---\nsensor_type: camera\ncomment: VI-Sensor\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0]\nrate_hz: 20\n"
        "resolution: [640, 480]\ncamera_model: pinhole\nintrinsics: [500.0, 501.0, 320.0, 240.0]\ndistortion_model: radtan\n"
        "distortion_coefficients: [-0.1, 0.05, 0.001, 0.0]\n")
    rows = ["#timestamp [ns],filename,exposure", *(f"{100 + i}000000, {100 + i}000000.png ,5\r" for i in range(COUNT)), "105000000,105000000.png,5", "999000000,999.png,5"]
    (tmp_path / "wild/mav0/cam1/data.csv").write_text("\n".join(rows))
    sequence, out = imported(tmp_path / "wild", "--camera", "cam1")
    assert sequence.timestamp_ns.tolist() == [1_000_000 * (100 + i) for i in range(COUNT)] and same(sequence, frames)
    assert sequence.camera.intrinsics_px.tolist() == [500, 501, 320, 240] and sequence.camera.distortion.tolist() == [-0.1, 0.05, 0.001, 0]
    assert "1 frames: time repeats" in out and "1 frames: listed, but the file is missing" in out


def bag_messages(version, frames, kind="raw"):
    store = sources.ros_types(version)
    messages = []
    for index, pixels in enumerate(frames):
        time_ns = 1_700_000_000 * NS + index * NS // 10
        if kind == "compressed":
            octets = (SAMPLE / "mav0/cam0/data" / f"{1_700_000_000 * NS + index * NS}.png").read_bytes()
            messages.append(("/cam/image_raw/compressed", time_ns + 7, sources.compressed_message(store, octets, time_ns)))
        else:
            messages.append(("/cam/image_raw", time_ns + 7, sources.image_message(store, pixels, time_ns, padding=8)))
        matrix = [[888.9, 0, 319.5], [0, 888.9, 239.5], [0, 0, 1]]
        messages.append(("/cam/camera_info", time_ns + 8, sources.info_message(store, 640, 480, matrix, [0.01, 0, 0, 0, 0])))
    return messages


# verifies: GND-03
@pytest.mark.parametrize(("version", "kind", "storage", "name"), [
    (1, "raw", None, "a.bag"), (1, "compressed", None, "a.bag"), (2, "raw", "SQLITE3", "bag"), (2, "compressed", "MCAP", "bag")])
def test_bags(imported, frames, tmp_path, version, kind, storage, name):
    sources.write_bag(tmp_path / name, version, bag_messages(version, frames, kind), storage)
    paths = [tmp_path / name, *(tmp_path / name).glob("*.mcap")]  # the file of a bag alone, too
    for path in paths:
        sequence, out = imported(path, name=f"SEQ_{path.name}")
        assert np.diff(sequence.timestamp_ns).tolist() == [NS // 10] * (COUNT - 1) and sequence.timestamp_ns[0] == 1_700_000_000 * NS
        assert same(sequence, frames)
        assert sequence.camera.intrinsics_px.tolist() == [888.9, 888.9, 319.5, 239.5] and sequence.camera.distortion[0] == 0.01
        assert "/cam/camera_info" in out


def test_several_topics_have_to_be_chosen_from(imported, refused, frames, tmp_path):
    store = sources.ros_types(2)
    messages = [(topic, NS + 1_000_000 * i, sources.image_message(store, pixels, 0)) for i, pixels in enumerate(frames) for topic in ("/left", "/right")]
    sources.write_bag(tmp_path / "bag", 2, messages)
    assert "2 topics of pictures, choose one by --topic: /left, /right" in refused(tmp_path / "bag", "--intrinsics", INTRINSICS)
    assert "no pictures there; topics are" in refused(tmp_path / "bag", "--intrinsics", INTRINSICS, "--topic", "/up")
    sequence, out = imported(tmp_path / "bag", "--intrinsics", INTRINSICS, "--topic", "/right")
    assert sequence.timestamp_ns.tolist() == [NS + 1_000_000 * i for i in range(COUNT)] and "header.stamp is 0" in out


@pytest.mark.parametrize(("encoding", "pixels", "gray"), [
    ("rgb8", [[[200, 100, 50]]], 0.299 * 200 + 0.587 * 100 + 0.114 * 50),
    ("bgr8", [[[50, 100, 200]]], 0.299 * 200 + 0.587 * 100 + 0.114 * 50),
    ("bgra8", [[[50, 100, 200, 255]]], 0.299 * 200 + 0.587 * 100 + 0.114 * 50),
    ("yuv422_yuy2", [[[120, 128]]], 120),
    ("mono16", [[[0x30, 0x12]]], 0x1230),
])
def test_encodings_become_gray(encoding, pixels, gray):
    from polhode_ground.importing.bag import raw_pixels
    message = sources.image_message(sources.ros_types(2), np.tile(np.array(pixels, np.uint8), (4, 6, 1)), 0, encoding, padding=4)
    message.width = 6
    found = raw_pixels(message, "bag")
    assert found.shape == (4, 6) and np.abs(found.astype(float) - gray).max() <= 1


def test_bayer_patterns_are_those_of_ros():
    from polhode_ground.importing.bag import raw_pixels
    red_only = np.zeros((8, 8), np.uint8)
    red_only[::2, ::2] = 200  # rggb: red at even rows and columns
    message = sources.image_message(sources.ros_types(2), red_only, 0, "bayer_rggb8")
    assert np.abs(raw_pixels(message, "bag")[2:-2, 2:-2].astype(float) - 0.299 * 200).max() <= 2


def test_the_mcap_of_our_own_tool_comes_back(imported, frames, tmp_path):
    subprocess.run([sys.executable, REPOSITORY / "tools/sequence_to_mcap.py", SAMPLE, "--out", tmp_path / "run.mcap"], check=True, capture_output=True)
    sequence, _ = imported(tmp_path / "run.mcap", "--intrinsics", INTRINSICS, "--to", COUNT - 1)
    assert same(sequence, frames) and sequence.timestamp_ns[0] == 1_700_000_000 * NS


@pytest.mark.parametrize(("name", "content", "says"), [
    ("notes.txt", b"hello", "not a video that can be read"),
    ("torn.bag", b"#ROSBAG V2.0\ntorn", "not a bag that can be read"),
    ("torn.mcap", b"\x89MCAP0\r\ntorn", "not an MCAP file that can be read"),
    ("torn.db3", b"SQLite", "not a bag that can be read"),
])
def test_what_is_no_source_is_refused_in_one_line(refused, tmp_path, name, content, says):
    (tmp_path / name).write_bytes(content)
    assert says in refused(tmp_path / name, "--intrinsics", INTRINSICS)


@pytest.mark.parametrize("name", ["one.jpg", "one.png"])
def test_a_single_picture_is_no_source(refused, frames, tmp_path, name):
    Image.fromarray(frames[0]).save(tmp_path / name)
    assert "found a single picture; expected a video, a folder of pictures" in refused(tmp_path / name, "--intrinsics", INTRINSICS)


def test_folders_without_pictures_are_told_by_their_contents(refused, tmp_path):
    (tmp_path / "docs").mkdir()
    assert "an empty folder; expected a video, a folder of pictures" in refused(tmp_path / "docs")
    (tmp_path / "docs/a.txt").write_text("")
    assert "a folder with a.txt; expected" in refused(tmp_path / "docs")
    assert "not there; expected" in refused(tmp_path / "nowhere")


def test_a_sequence_that_is_there_is_not_written_over(run, frames, tmp_path):
    (tmp_path / "SEQ").mkdir()
    done = run(SAMPLE, tmp_path / "SEQ")
    assert done.returncode == 2 and "is there already" in done.stderr and not list((tmp_path / "SEQ").iterdir())
