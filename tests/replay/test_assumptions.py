"""What contradicts the assumptions is refused where it is certain, and told where it is doubtful."""

import json

import pytest
from polhode_ground.testing.replay_files import summary

WARNING = "polhode: warning: "


def restamped(sequence, unit_ns: int) -> None:
    sequence.rows = [(str(int(stamp) // unit_ns), name) for stamp, name in sequence.rows]
    sequence.table()


def changed(sequence, before: str, after: str) -> None:
    text = (sequence.camera / "sensor.yaml").read_text()
    assert before in text
    sequence.sensor(text.replace(before, after))


def told(result) -> list[str]:
    assert result.status == 0, result.err
    return [line.removeprefix(WARNING) for line in result.err.splitlines() if line.startswith(WARNING)]


def test_a_good_sequence_has_no_warning(replay, sequence):
    result = replay(sequence.path)
    assert told(result) == []
    assert summary(result.folder)["warnings"] == []


@pytest.mark.parametrize(("unit_ns", "says"), [(1000, "microseconds"), (1_000_000, "milliseconds"), (100_000_000, "seconds or frame numbers")])
def test_stamps_in_another_unit_are_refused(replay, sequence, unit_ns, says):
    restamped(sequence, unit_ns)  # of a tenth of a second: frame numbers
    result = replay(sequence.path)
    assert result.status == 2 and not result.folder.exists()
    line, = result.err.splitlines()
    assert "data.csv: timestamp [ns]: the pictures are" in line and "sensor.yaml says rate_hz: 10" in line
    assert unit_ns == 100_000_000 or says in line


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("rate_hz: 10", "rate_hz: 30", "data.csv: timestamp [ns]: the pictures are 0.1 s apart in the median, but sensor.yaml says rate_hz: 30"),
        ("rate_hz: 10", "rate_hz: fast", "sensor.yaml: rate_hz: 'fast' is not a number above 0"),
        ("rate_hz: 10", "rate_hz: 10\nreadout_time: 0.015", "sensor.yaml: readout_time: a rolling shutter"),
        ("rate_hz: 10", "rate_hz: 10\nshutter: rolling", "sensor.yaml: shutter: a rolling shutter"),
        ("200.0, 200.0, 79.5, 59.5", "400.0, 400.0, 159.5, 119.5", "sensor.yaml: intrinsics: the principal point (159.5, 119.5)"),
    ],
)
def test_what_is_doubtful_is_told_and_kept(replay, sequence, before, after, says):
    changed(sequence, before, after)
    result = replay(sequence.path)
    line, = told(result)
    assert says in line
    assert json.loads((result.folder / "summary.json").read_text())["warnings"] == [line]


@pytest.mark.parametrize("line", ["line_time_ns: 0", "rolling_shutter: false", "shutter: global", "shutter: rolling\nline_time_ns: 15000"])
def test_a_shutter_that_is_known_is_not_remarked_on(replay, sequence, line):
    changed(sequence, "rate_hz: 10", f"rate_hz: 10\n{line}")
    assert told(replay(sequence.path)) == []


def test_intrinsics_in_another_order_are_refused(replay, sequence):
    changed(sequence, "200.0, 200.0, 79.5, 59.5", "200.0, 79.5, 200.0, 59.5")
    result = replay(sequence.path)
    assert result.status == 2 and not result.folder.exists()
    line, = result.err.splitlines()
    assert "sensor.yaml: intrinsics: 200, 79.5, 200, 59.5 make no camera of 160x120 px" in line
    assert "look like fu, cu, fv, cv" in line


def test_check_and_run_judge_a_configured_camera(program, tmp_path):
    camera = "[camera]\nwidth_px = 640\nheight_px = 480\nfu_px = 900\nfv_px = {fv}\ncu_px = {cu}\ncv_px = 239.5\n"
    config = tmp_path / "config.toml"
    config.write_text(camera.format(fv=900, cu=319.5))
    assert WARNING not in program("check", "--config", config).err
    config.write_text(camera.format(fv=900, cu=20))
    assert f"{WARNING}{config}: [camera] intrinsics: the principal point (20, 239.5)" in program("check", "--config", config).err
    config.write_text(camera.format(fv=319.5, cu=900))
    result = program("check", "--config", config)
    assert result.status == 2 and f"{config}: [camera] intrinsics: 900, 319.5, 900, 239.5 make no camera" in result.err
