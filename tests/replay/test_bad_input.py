"""Sequences that cannot be used: one clear line that names file and field, exit 2, and nothing written."""

import shutil

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, motion_rows, summary
from polhode_ground.testing.sequence_writer import uniform, write_image


def refused(result, *parts):
    assert result.status == 2, result.err
    lines = result.err.strip().splitlines()
    assert len(lines) == 1, result.err
    assert lines[0].startswith("polhode: ")
    for part in parts:
        assert part in lines[0], lines[0]
    assert not result.folder.exists()


def test_absent_folder(replay, tmp_path):
    refused(replay(tmp_path / "nowhere"), "nowhere: no such folder")


def test_folder_that_is_no_sequence(replay, tmp_path):
    (tmp_path / "photos").mkdir()
    refused(replay(tmp_path / "photos"), "photos: not an image sequence: mav0/cam0/data.csv is missing",
            "tools/import_sequence.py SOURCE SEQ")


def test_file_instead_of_folder(replay, tmp_path):
    (tmp_path / "film.avi").write_bytes(b"RIFF")
    refused(replay(tmp_path / "film.avi"), "film.avi: a file, no such folder", "tools/import_sequence.py SOURCE SEQ")


def test_missing_sensor_yaml(replay, sequence):
    (sequence.camera / "sensor.yaml").unlink()
    refused(replay(sequence.path), "sensor.yaml: cannot be read: No such file or directory")


def test_intrinsics_that_are_yet_to_be_estimated(replay, sequence):
    text = (sequence.camera / "sensor.yaml").read_text()
    sequence.sensor("".join("intrinsics: auto\n" if line.startswith("intrinsics") else line for line in text.splitlines(True)))
    refused(replay(sequence.path), "intrinsics: 'auto', allowed are 4 numbers", f"tools/import_sequence.py {sequence.path} --intrinsics auto")


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("[160, 120]", "[160]", "resolution: '[160]', allowed are 2 numbers"),
        ("[160, 120]", "[160, 0]", "resolution[1]: 0 is out of range, allowed 32 .. 8192"),
        ("[160, 120]", "[161, 120]", "image is 160x120, but sensor.yaml says resolution: [161, 120]"),
        ("pinhole", "fisheye", "camera_model: 'fisheye', allowed is 'pinhole'"),
        ("200.0, 200.0", "200.0, 0.0", "intrinsics[1]: 0.0 is out of range, allowed 10.0 .. 1000000.0"),
        ("distortion_coefficients: [0.0, 0.0, 0.0, 0.0]", "", "distortion_coefficients: field is missing"),
        ("distortion_coefficients: [0.0,", "distortion_coefficients: [x,", "distortion_coefficients: 'x' is not a number"),
        ("camera_model: ", "camera_model: [", "not YAML"),
    ],
)
def test_unusable_sensor_yaml(replay, sequence, before, after, says):
    text = (sequence.camera / "sensor.yaml").read_text()
    assert before in text
    sequence.sensor(text.replace(before, after))
    refused(replay(sequence.path), says)


@pytest.mark.parametrize(
    ("stamps", "says"),
    [
        (["5", "5", "6"], "data.csv:3: timestamp [ns]: 5 repeats"),
        (["5", "7", "6"], "data.csv:4: timestamp [ns]: 6 runs back"),
        (["5", "soon", "6"], "data.csv:3: timestamp [ns]: 'soon'"),
        (["-1", "5", "6"], "data.csv:2: timestamp [ns]: '-1'"),
    ],
)
def test_time_stamps(replay, sequence, stamps, says):
    sequence.rows = [(stamp, name) for stamp, (_, name) in zip(stamps, sequence.rows)]
    sequence.table()
    refused(replay(sequence.path), says)


@pytest.mark.parametrize("known", [["scale.range_m=8.0"], ["scale.known_length_m=0.6", "scale.points_px=[[10.0,20.0],[40.0,50.0]]"]])
def test_a_scale_of_a_frame_that_is_not_there(program, replay, sequence, known):
    """The frames are of 1.0, 1.1 and 1.2 s."""
    def told(stamp):
        return [part for setting in [*known, f"scale.frame_timestamp_ns={stamp}"] for part in ("--set", setting)]

    for stamp in (5, 1_300_000_000, 1_000_000_001):
        dropped = stamp == 1_000_000_001
        says = (f"--set scale.frame_timestamp_ns={stamp}: scale.frame_timestamp_ns = {stamp}: no frame of the sequence has this time; "
                "the first has 1000000000, the last 1200000000")
        checked = program("check", "--config", DEFAULTS, "--sequence", sequence.path, *told(stamp))
        assert checked.status == (0 if dropped else 2) and says in checked.err
        if dropped:
            replayed = replay(sequence.path, *told(stamp))
            assert replayed.status == 0 and says in replayed.err
        else:
            refused(replay(sequence.path, *told(stamp)), says)
    assert replay(sequence.path, *told(1_100_000_000)).status == 0


def test_empty_sequence(replay, sequence):
    sequence.rows = []
    sequence.table()
    refused(replay(sequence.path), "data.csv: the sequence has no frames")


def test_row_without_a_name(replay, sequence):
    sequence.rows[1] = (sequence.rows[1][0], "")
    sequence.table()
    refused(replay(sequence.path), "data.csv:3: filename: ''")


def test_no_image_at_all(replay, sequence):
    shutil.rmtree(sequence.data)
    refused(replay(sequence.path), "none of the 3 images can be read", "No such file")


def test_first_image_of_another_size(replay, sequence):
    write_image(sequence.data / sequence.rows[0][1], uniform(5)[:60])
    refused(replay(sequence.path), "image is 160x60, but sensor.yaml says resolution: [160, 120]")


def spoil(kind, file):
    whole = file.read_bytes()
    if kind == "missing":
        file.unlink()
    elif kind == "empty":
        file.write_bytes(b"")
    elif kind == "truncated":
        file.write_bytes(whole[: len(whole) * 2 // 3])
    elif kind == "damaged":
        file.write_bytes(whole[: len(whole) // 2] + b"\x00" * 64 + whole[len(whole) // 2 + 64 :])
    elif kind == "other size":
        write_image(file, uniform(80)[:100])
    elif kind == "text":
        file.write_text("not an image")
    elif kind == "huge":
        file.write_bytes(whole + bytes(30 << 20))  # more than the pools and their reserve hold beside the rest
    elif kind == "folder":
        file.unlink()
        file.mkdir()


KINDS = ["missing", "empty", "truncated", "damaged", "other size", "text", "huge", "folder"]


# Only PNG has a checksum that tells of damage.
@pytest.mark.parametrize(("suffix", "kind"), [(suffix, kind) for suffix in (".png", ".jpg", ".pgm") for kind in KINDS if suffix == ".png" or kind != "damaged"])
def test_a_single_bad_frame_is_counted_and_the_run_goes_on(replay, tmp_path, suffix, kind):
    from polhode_ground.testing.sequence_writer import SequenceWriter, textured

    writer = SequenceWriter(tmp_path / "spoiled", suffix)
    files = [writer.add(textured(seed)) for seed in range(4)]
    spoil(kind, files[1])
    result = replay(writer.path)
    assert result.status == 0, result.err
    rows, told = motion_rows(result.folder), summary(result.folder)
    assert [row["frame"] for row in rows] == ["0", "1", "2", "3"]
    assert rows[1]["pose_valid"] == "0" and rows[1]["features"] == ""
    assert told["frames"]["in"] == 4 and told["frames"]["processed"] == 3
    assert told["counters"]["frames_unreadable"] == 1
    assert [bad["frame"] for bad in told["bad_frames"]] == [1]
    assert files[1].name in told["bad_frames"][0]["reason"]
    assert f"frame 1 is not used: {files[1].name}" in result.err


def test_a_bad_first_frame_is_no_reason_to_stop(replay, sequence):
    (sequence.data / sequence.rows[0][1]).write_bytes(b"")
    result = replay(sequence.path)
    assert result.status == 0 and summary(result.folder)["frames"]["processed"] == 2
