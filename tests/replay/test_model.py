"""The next pass: what one replay has learnt of its target is given to another one, of other pictures."""

import csv
import math

import numpy as np
import pytest
import yaml
from attitudes import mean_rotation, off_deg, rotation
from PIL import Image
from polhode_ground.testing.replay_files import DEFAULTS, motion_rows, summary
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

FIRST, SECOND = range(45), range(30, 44)
SCALE = 0.7  # of the second pass's pictures: another camera


def part_of(sample, folder, frames):
    """Some frames of the sample, its pictures linked."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    for name in ("data", "sensor.yaml"):
        (camera / name).symlink_to(sample / "mav0/cam0" / name)
    head, *lines = (sample / "mav0/cam0/data.csv").read_text().splitlines()
    (camera / "data.csv").write_text("\n".join([head, *(lines[i] for i in frames)]) + "\n")
    return folder


def in_other_light(sample, folder, frames):
    """Frames of the sample in a smaller picture, darker and with another contrast, turned upside down."""
    camera = folder / "mav0/cam0"
    (camera / "data").mkdir(parents=True)
    sensor = (sample / "mav0/cam0/sensor.yaml").read_text()
    known = yaml.safe_load(sensor.replace("%YAML:1.0", ""))
    width, height = (round(SCALE * side) for side in known["resolution"])
    fu, fv, cu, cv = known["intrinsics"]
    turned = [SCALE * fu, SCALE * fv, width - 1 - (SCALE * (cu + 0.5) - 0.5), height - 1 - (SCALE * (cv + 0.5) - 0.5)]
    known.update(resolution=[width, height], intrinsics=turned)
    k1, k2, p1, p2 = known["distortion_coefficients"]
    known["distortion_coefficients"] = [k1, k2, -p1, -p2]
    (camera / "sensor.yaml").write_text("%YAML:1.0\n" + yaml.safe_dump(known))
    head, *lines = (sample / "mav0/cam0/data.csv").read_text().splitlines()
    for i in frames:
        name = lines[i].split(",")[1].strip()
        with Image.open(sample / "mav0/cam0/data" / name) as image:
            small = np.asarray(image.convert("L").resize((width, height), Image.Resampling.LANCZOS), dtype=float)
        dark = 0.5 * 255.0 * (small[::-1, ::-1] / 255.0) ** 1.4
        Image.fromarray(np.round(dark).astype(np.uint8)).save(camera / "data" / name)
    (camera / "data.csv").write_text("\n".join([head, *(lines[i] for i in frames)]) + "\n")
    return folder


@pytest.fixture(scope="module")
def first(program, sample, tmp_path_factory):
    folder = tmp_path_factory.mktemp("first")
    sequence = part_of(sample, folder / "sequence", FIRST)
    done = program("replay", "--config", DEFAULTS, "--sequence", sequence, "--out", folder / "out", "--save-model", folder / "target.model")
    assert done.status == 0, done.err
    done.folder, done.model = folder / "out", folder / "target.model"
    return done


@pytest.fixture
def truth(sample):
    with open(sample / "truth.csv", encoding="ascii", newline="") as table:
        return {row["timestamp_ns"]: row for row in csv.DictReader(table)}


# verifies: MAP-12
def test_it_is_recognised_in_the_same_t(first, replay, sample, truth, tmp_path):
    known = [row for row in motion_rows(first.folder) if row["pose_valid"] == "1"][-20:]
    R_TT = mean_rotation([rotation(truth[row["timestamp_ns"]]).T @ rotation(row) for row in known])
    result = replay(in_other_light(sample, tmp_path / "second", SECOND), "--model", first.model)
    assert result.status == 0, result.err
    assert "recognised by its model" in result.out and summary(result.folder)["model"] == {"file": str(first.model), "recognised": True}
    rows = [row for row in motion_rows(result.folder) if row["pose_valid"] == "1"]
    assert rows and int(rows[0]["frame"]) < 10 and {row["target_frame"] for row in rows} == {"1"}
    for row in rows:
        w, x, y, z = (float(row[f"q_CT_{axis}"]) for axis in "wxyz")
        upright = {**row, "q_CT_w": -z, "q_CT_x": -y, "q_CT_y": x, "q_CT_z": w}  # half a turn about the boresight before it
        assert off_deg(upright, truth, R_TT) < 3.4 * math.degrees(float(row["sigma_att_rad"])) + 0.3, row["frame"]


# verifies: MAP-12
def test_another_body_is_not_taken_for_it(first, replay, tmp_path):
    writer = SequenceWriter(tmp_path / "other")
    for seed in range(12):
        writer.add(textured(seed // 4))
    result = replay(writer.path, "--model", first.model)
    assert result.status == 0, result.err
    assert not [row for row in motion_rows(result.folder) if row["pose_valid"] == "1" and row["target_frame"] == "1"]
    assert "recognised by its model nor acquired" in result.out and summary(result.folder)["model"]["recognised"] is False


def test_a_model_says_what_is_in_it(first, program):
    done = program("model", "check", first.model)
    assert done.status == 0 and "landmarks from" in done.out and "scale: unknown" in done.out, done.err


def test_what_is_no_model_is_refused_with_the_reason(first, program, replay, sequence, tmp_path):
    whole = first.model.read_bytes()
    for name, content, reason in [("cut", whole[:5000], "cut off or damaged"), ("damaged", whole[:9000] + bytes([whole[9000] ^ 4]) + whole[9001:], "cut off or damaged"),
                                  ("text", b"my notes\n" * 9, "no model of a target"), ("empty", b"", "no model of a target")]:
        file = tmp_path / name
        file.write_bytes(content)
        for done in (program("model", "check", file), replay(sequence.path, "--model", file)):
            assert done.status == 2 and str(file) in done.err and reason in done.err, done.err
    done = program("model", "check", tmp_path / "absent")
    assert done.status == 2 and "absent" in done.err


def test_a_file_of_somebody_else_is_not_replaced(replay, sequence, tmp_path):
    notes = tmp_path / "notes"
    notes.write_text("mine\n")
    done = replay(sequence.path, "--save-model", notes)
    assert done.status == 2 and "no model of a target" in done.err and notes.read_text() == "mine\n"
    for place in (tmp_path / "absent/target.model", tmp_path / "out/summary.json"):
        (tmp_path / "out").mkdir(exist_ok=True)
        done = replay(sequence.path, "--save-model", place)
        assert done.status == 2 and str(place) in done.err, done.err


def test_a_model_stays_where_its_target_was_not_recognised(first, program, sample, tmp_path):
    """Another body's map does not take its place."""
    kept = tmp_path / "target.model"
    kept.write_bytes(first.model.read_bytes())
    backwards = in_other_light(sample, tmp_path / "mirrored", range(14))
    for file in (backwards / "mav0/cam0/data").iterdir():
        with Image.open(file) as image:
            image.transpose(Image.Transpose.FLIP_LEFT_RIGHT).resize((200, 160)).resize(image.size).save(file)
    done = program("replay", "--config", DEFAULTS, "--sequence", backwards, "--out", tmp_path / "out", "--model", kept, "--save-model", kept)
    assert done.status == 1 and str(kept) in done.err and kept.read_bytes() == first.model.read_bytes(), done.err


def test_without_a_map_the_run_is_whole_and_the_model_is_missed(replay, sequence, tmp_path):
    done = replay(sequence.path, "--save-model", tmp_path / "target.model")
    assert done.status == 1 and "there is no map" in done.err
    assert (done.folder / "summary.json").exists() and not (tmp_path / "target.model").exists()
