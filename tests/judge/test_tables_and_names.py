"""What replays is judged: data.csv and sensor.yaml in every form that the replay reads, folders and files of every name."""

import json
import os
import pathlib
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.common.program import PROGRAM
from polhode_ground.common.sequence import read_sequence
from polhode_ground.common.venv import own_environment
from polhode_ground.testing.synthetic import write_acquired

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SENSOR = """\
sensor_type: camera
rate_hz: 2.0
resolution: [64, 48]
camera_model: pinhole
intrinsics: [60.0, 61.0, 31.5, 23.5]
distortion_model: radial-tangential
distortion_coefficients: [0.1, -0.2, 0.001, 0.002]
"""
TABLE = "#timestamp [ns],filename\n1000000000,a.png\n1500000000,b.png\n2000000000,c.png\n"
BLOCK = SENSOR.replace("[60.0, 61.0, 31.5, 23.5]", "\n- 60.0\n- 61.0\n# right\n- 31.5\n- 23.5").replace("[64, 48]", "\n  - 64\n  - 48")
# Names that are no UTF-8, that a shell or a message takes for more than a name, and that an option looks like.
NAMES = [b"gr\xe4\xdfe", b"two\nlines", b"-x", b"it's \"q\" $HOME %d {0}", "größe–日本".encode(), b"a,b=c;d #1"]


def written(folder: pathlib.Path, table: str | bytes = TABLE, sensor: str | bytes = SENSOR) -> pathlib.Path:
    camera = folder / "mav0/cam0"
    (camera / "data").mkdir(parents=True)
    for name, content in (("data.csv", table), ("sensor.yaml", sensor)):
        (camera / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder


@pytest.mark.parametrize(("table", "sensor"), [
    (TABLE, SENSOR),
    (TABLE.split("\n", 1)[1], SENSOR),  # no header
    (TABLE.replace("1500", "# exposure changed here, 2 ms\n\n  # again\n1500"), SENSOR),
    ("# camera 1, left\n# written by hand\n" + TABLE, SENSOR),
    (TABLE.replace("\n", "\r\n"), SENSOR.replace("\n", "\r\n")),
    (TABLE.rstrip("\n").replace("\n", "\r"), SENSOR),
    ("\ufeff" + TABLE, "\ufeff" + SENSOR),
    (TABLE.replace(",", " ,\t"), SENSOR),
    (TABLE.replace(".png", ".png,0.002,gain 3"), SENSOR),  # further columns
    (TABLE, BLOCK),
    (TABLE, SENSOR.replace("31.5, 23.5]", "\n  31.5, 23.5]  # cu, cv")),
    (TABLE, SENSOR.replace("pinhole", "'pinhole'") + "nested:\n  a: [1, 2]\n"),
    (TABLE, json.dumps(dict(line.split(": ") for line in SENSOR.splitlines())).replace('"[', "[").replace(']"', "]").replace('"2.0"', "2.0")),
], ids=["plain", "no header", "remarks", "remarks before", "crlf", "cr", "mark", "white space", "columns", "block", "two lines", "nested", "json"])
def test_every_form_that_replays_is_read_alike(tmp_path, table, sensor):
    sequence = read_sequence(written(tmp_path / "seq", table, sensor))
    assert sequence.timestamp_ns.tolist() == [1_000_000_000, 1_500_000_000, 2_000_000_000] and sequence.filenames == ["a.png", "b.png", "c.png"]
    assert (sequence.camera.width_px, sequence.camera.height_px, sequence.rate_hz) == (64, 48, 2.0)
    assert np.array_equal(sequence.camera.intrinsics_px, [60, 61, 31.5, 23.5]) and np.array_equal(sequence.camera.distortion, [0.1, -0.2, 0.001, 0.002])


@pytest.mark.parametrize(("table", "sensor"), [
    (TABLE.replace("1500000000", "1.5e9"), SENSOR),
    (TABLE.replace("1500000000", "900000000"), SENSOR),
    (TABLE.replace("b.png", "../b.png"), SENSOR),
    (TABLE, SENSOR.replace("pinhole", "omni")),
    (TABLE, SENSOR.replace("[60.0, 61.0, 31.5, 23.5]", "auto")),
], ids=["a time", "order", "a name", "a model", "auto"])
def test_what_does_not_replay_is_refused_in_the_replays_words(tmp_path, table, sensor):
    folder = written(tmp_path / "seq", table, sensor)
    with pytest.raises(BadInput) as refused:
        read_sequence(folder)
    replay = subprocess.run([PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", folder, "--out", tmp_path / "run"],
                            capture_output=True, text=True)
    assert replay.returncode == 2 and replay.stderr.splitlines()[-1] == f"polhode: {refused.value}"


def test_a_focal_length_to_be_estimated_is_a_guess_where_that_is_asked_for(tmp_path):
    sequence = read_sequence(written(tmp_path / "seq", sensor=SENSOR.replace("[60.0, 61.0, 31.5, 23.5]", "auto") + "sigma_focal_px: 0.5\n"), any_lens=True)
    assert not sequence.intrinsics_known and sequence.camera.intrinsics_px.tolist() == [64, 64, 31.5, 23.5]
    assert sequence.fields["sigma_focal_px"] == "0.5"


@pytest.mark.parametrize("name", [name for name in NAMES if b"," not in name and b"\n" not in name], ids=ascii)
def test_pictures_of_any_name_are_found(tmp_path, name):
    """But for those that a table of commas and lines cannot hold."""
    folder = written(tmp_path / os.fsdecode(name), table=b"5," + name + b".png\n")
    Image.new("L", (64, 48), 7).save(folder / "mav0/cam0/data" / (os.fsdecode(name) + ".png"))
    assert read_sequence(folder).read_gray(0)[0, 0] == 7


def test_folders_of_any_name_are_imported_replayed_and_shown(tmp_path):
    """In a shell of another language, too, whose text is not UTF-8."""
    name = b"-gr\xe4\xdfe\n'x'"
    here = tmp_path / os.fsdecode(name)
    (here / os.fsdecode(name)).mkdir(parents=True)
    for number in range(2):
        Image.new("L", (64, 48), 40 * number).save(here / os.fsdecode(name) / (os.fsdecode(name) + f"{number}.png"))

    def call(*words) -> bytes:
        done = subprocess.run([word if isinstance(word, bytes) else os.fsencode(str(word)) for word in words], capture_output=True, cwd=here,
                              env={**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"})
        assert done.returncode == 0, done.stderr
        return done.stdout

    said = call(REPOSITORY / "tools/import_sequence.py", "--rate-hz", "1", "--intrinsics", "60,60,31.5,23.5", "--", name, name + b"_seq")
    assert name + b"_seq" in said
    call(PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", b"--sequence=" + name + b"_seq", b"--out=" + name + b"_run")
    call(REPOSITORY / "tools/report.py", "--", name + b"_run")
    page = (here / (os.fsdecode(name) + "_run") / "report.html").read_bytes()
    assert page.count(b"data:image/jpeg;base64,") == 2


def test_interpreters_that_are_started_get_nothing_of_other_pythons(monkeypatch):
    for name in ("PYTHONPATH", "PYTHONHOME", "PYTHONSTARTUP", "PYTHONUSERBASE"):
        monkeypatch.setenv(name, "/not/there")
    assert {name for name in own_environment() if name.startswith("PYTHON")} == {"PYTHONNOUSERSITE", "PYTHONUTF8"}


def test_a_run_and_a_sequence_of_other_names_are_judged(tmp_path):
    sequence, run = write_acquired(tmp_path / "made", frames=10)
    odd = tmp_path / os.fsdecode(NAMES[0])
    shutil.move(tmp_path / "made", odd)
    done = subprocess.run([REPOSITORY / "hil/evaluate.py", odd / "run", odd / "seq", "--json", odd / "judged.json"], capture_output=True,
                          env={**os.environ, "LC_ALL": "C"})
    assert done.returncode == 0 and json.loads((odd / "judged.json").read_text())["runs"], done.stderr


@pytest.mark.parametrize(("change", "coding"), [
    (lambda text: text, "utf-8-sig"), (lambda text: text, "utf-16"), (lambda text: text.replace(",", ";").replace(".", ","), "utf-8"),
    (lambda text: text.replace(",", "\t"), "utf-8"), (lambda text: text.replace("\n2", "\n# lost\n2"), "utf-8")])
def test_a_truth_of_a_spreadsheet_is_read(tmp_path, change, coding):
    from polhode_ground.common.tables import read_motion
    text = "timestamp_ns,q_CT_w,q_CT_x,q_CT_y,q_CT_z,p_CT_x,p_CT_y,p_CT_z\n1000000000,1.0,0,0,0,0.5,0,2.5\n2000000000,1.0,0,0,0,0.5,0,3.5\n"
    (tmp_path / "truth.csv").write_bytes(change(text).encode(coding))
    motion = read_motion(tmp_path / "truth.csv")
    assert motion.timestamp_ns.tolist() == [10**9, 2 * 10**9] and motion.p_CT.tolist() == [[0.5, 0, 2.5], [0.5, 0, 3.5]]
