"""The time from row to row is carried on from calibrations and sequences; the program's doubts and limits are asked at import."""

import cv2
import numpy as np
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.calibration_files import read_lens
from polhode_ground.importing.lens import scaled_to
from polhode_ground.importing.row_times import row_time_of

KALIBR = ("cam0:\n  camera_model: pinhole\n  intrinsics: [100, 100, 31.5, 23.5]\n  distortion_coeffs: [0, 0, 0, 0]\n  distortion_model: radtan\n"
          "  resolution: [64, 48]\n  line_delay: 3.0e-05\n")


@pytest.mark.parametrize(("values", "time_ns", "says"), [
    ({"line_time_ns": 20000}, 20000, ""), ({"line_delay": 3e-5}, 30000, "line_time_ns is 30000"), ({"lineTimeUs": "20"}, 20000, "line_time_ns is 20000"),
    ({"row_delay_ms": 0.02}, 20000, "is 20000"), ({"line_time": 20000}, 0, "in a known unit"), ({"readout_time": 0.03}, 0, "state line_time_ns"),
    ({"shutter": "Rolling"}, 0, "state line_time_ns"), ({"shutter": "global", "line_time_ns": 0, "rolling_shutter": False, "shutter_speed": 9}, 0, "")])
def test_names_and_units(values, time_ns, says):
    found_ns, said = row_time_of(values, "file")
    assert found_ns == pytest.approx(time_ns) and says in said and bool(said) == bool(says)


def test_a_word_is_no_time():
    with pytest.raises(BadInput, match="line_time_ns: '20 us' is not a number"):
        row_time_of({"line_time_ns": "20 us"}, "file")


def test_rows_of_smaller_pictures_take_longer(tmp_path):
    (tmp_path / "kalibr.yaml").write_text(KALIBR)
    lens = read_lens(tmp_path / "kalibr.yaml")
    assert lens.line_time_ns == 30000 and scaled_to(lens, 32, 24, "it")[0].line_time_ns == 60000


@pytest.fixture
def source(tmp_path):
    """An EuRoC sequence of three small pictures, and its sensor.yaml."""
    camera = tmp_path / "source/mav0/cam0"
    (camera / "data").mkdir(parents=True)
    for index in range(3):
        cv2.imwrite(str(camera / f"data/{index}.png"), np.random.default_rng(index).integers(0, 255, (48, 64), np.uint8))
    (camera / "data.csv").write_text("".join(f"{index * 100_000_000},{index}.png\n" for index in range(3)))
    return camera / "sensor.yaml"


def test_they_reach_the_sequence(source, run, tmp_path):
    source.write_text("camera_model: pinhole\nresolution: [64, 48]\nintrinsics: auto\nline_time_ns: 9e6\n")
    done = run(tmp_path / "source", tmp_path / "SEQ", "--intrinsics", "100,100,31.5,23.5")
    assert done.returncode == 0, done.stderr
    assert "line_time_ns: 9000000" in (tmp_path / "SEQ/mav0/cam0/sensor.yaml").read_text()
    assert "doubtful: sensor.yaml: line_time_ns: all rows of a picture take 0.423 s" in done.stdout


@pytest.mark.parametrize(("intrinsics", "says"), [
    ("100,31.5,100,23.5", "polhode would not take it (intrinsics: --intrinsics): sensor.yaml: intrinsics: 100, 31.5, 100, 23.5 make no camera"),
    ("5,5,31.5,23.5", "sensor.yaml: intrinsics[0]: 5.0 is out of range")])
def test_what_a_replay_would_refuse_is_refused_by_its_words(source, refused, tmp_path, intrinsics, says):
    assert not source.exists()
    assert says in refused(tmp_path / "source", "--intrinsics", intrinsics)
