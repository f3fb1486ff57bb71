"""The servicer's own in the view, named as mask.file: it is no target, and a picture that can't be it is refused before the start."""

import json

import numpy
import pytest
from PIL import Image
from polhode_ground.testing.replay_files import REPOSITORY, SAMPLE, motion_rows, summary
from polhode_ground.testing.sequence_writer import HEIGHT, WIDTH, SequenceWriter, textured

FRAMES = 20
STEPS = [{"kind": "own_structure", "reach_part": 0.3}, {"kind": "caption", "height_part": 0.06}]


def named(file) -> list[str]:
    return ["--set", f'mask.file="{file}"']


def drawn(folder, pixels, name="own.png"):
    Image.fromarray(pixels).save(folder / name)
    return folder / name


def corner() -> numpy.ndarray:
    own = numpy.zeros((HEIGHT, WIDTH), numpy.uint8)
    own[80:, :50] = 255
    return own


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """(clean sequence, the same with an arm, a caption and a counter painted in, picture of where these are)."""
    from polhode_ground.transforms.footage import read_footage, write_footage
    from polhode_ground.transforms.table import KINDS, options_of
    folder = tmp_path_factory.mktemp("scenes")
    footage = read_footage(SAMPLE)
    clean = footage.changed(footage.shots[:FRAMES])
    painted = clean
    for step in STEPS:
        given = {key: value for key, value in step.items() if key != "kind"}
        painted = KINDS[step["kind"]].function(painted, options_of("test", step["kind"], given), 1)
    own = numpy.zeros((480, 640), bool)
    for before, after in zip(clean.shots, painted.shots):
        own |= before.pixels() != after.pixels()
    write_footage(clean, folder / "clean")
    write_footage(painted, folder / "painted")
    return folder / "clean", folder / "painted", drawn(folder, numpy.where(own, 255, 0).astype(numpy.uint8))


# verifies: MSK-06
def test_with_it_a_painted_view_gives_the_clean_ones_packets(replay, scenes, tmp_path):
    """What is painted covers black space alone: where it is left out, nothing has changed."""
    clean, painted, own = scenes
    runs = {"clean": replay(clean, out=tmp_path / "clean"), "own": replay(painted, *named(own), out=tmp_path / "own"),
            "without": replay(painted, out=tmp_path / "without")}
    assert all(run.status == 0 for run in runs.values())
    packets = {name: (run.folder / "bus.ccsds").read_bytes() for name, run in runs.items()}
    assert packets["own"] == packets["clean"] != packets["without"]
    assert sum(row["pose_valid"] == "1" for row in motion_rows(runs["own"].folder)) >= FRAMES - 5  # a map is begun on the fifth frame at the earliest
    told = summary(runs["own"].folder)["own_structure"]
    assert 0.01 < told["part_of_picture"] < 0.2 and len(told["sha256"]) == 64
    assert summary(runs["clean"].folder)["own_structure"] is None


def test_no_file_is_the_default(replay, tmp_path):
    writer = SequenceWriter(tmp_path / "seq")
    for seed in range(3):
        writer.add(textured(seed))
    plain, none = replay(writer.path, out=tmp_path / "a"), replay(writer.path, *named(""), out=tmp_path / "b")
    assert none.status == 0 and (none.folder / "bus.ccsds").read_bytes() == (plain.folder / "bus.ccsds").read_bytes()


@pytest.mark.parametrize(("name", "make", "says"), [
    ("own.png", lambda: numpy.zeros((100, 100), numpy.uint8), f"is 100 x 100, allowed is the camera's {WIDTH} x {HEIGHT}"),
    ("own.png", lambda: numpy.zeros((HEIGHT, WIDTH), numpy.uint8), "is black all over"),
    ("own.png", lambda: numpy.full((HEIGHT, WIDTH), 255, numpy.uint8), "is white all over"),
    ("own.png", lambda: textured(1), "are neither black nor white, allowed are 10 %"),
    ("own.jpg", corner, "is a JPEG"),
])
def test_a_picture_that_can_not_be_it_is_refused(program, tmp_path, name, make, says):
    writer = SequenceWriter(tmp_path / "seq")
    writer.add(textured(1))
    file = drawn(tmp_path, make(), name)
    for command in (["check", "--config", REPOSITORY / "config/default.toml", "--sequence", writer.path],
                    ["replay", "--config", REPOSITORY / "config/default.toml", "--sequence", writer.path, "--out", tmp_path / "out"]):
        done = program(*command, *named(file))
        assert done.status == 2 and f"mask.file: {file}: " in done.err and says in done.err and done.err.count("\n") == 1, done.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("content", [None, b"", b"no picture"])
def test_what_is_no_picture_is_refused(program, tmp_path, content):
    writer = SequenceWriter(tmp_path / "seq")
    writer.add(textured(1))
    file = tmp_path / "own.png"
    if content is not None:
        file.write_bytes(content)
    done = program("replay", "--config", REPOSITORY / "config/default.toml", "--sequence", writer.path, "--out", tmp_path / "out", *named(file))
    assert done.status == 2 and f"mask.file: {file}: " in done.err and done.err.count("\n") == 1, done.err


def test_it_is_a_text(program, tmp_path):
    config = tmp_path / "config.toml"
    config.write_text("[mask]\nfile = 3\n")
    done = program("check", "--config", config)
    assert done.status == 2 and "config.toml:2: mask.file: allowed is a text" in done.err


@pytest.mark.parametrize("name", ["own.png", "own.pgm"])
def test_a_live_run_reads_it_too(program, tmp_path, name):
    writer = SequenceWriter(tmp_path / "seq")
    for seed in range(4):
        writer.add(textured(seed))
    config = tmp_path / "live.toml"
    config.write_text(f'[device]\nsource = "{writer.path}"\nsequence_speed = 0.0\n[run]\nfolder = "{tmp_path}/run"\n[mask]\nfile = "{drawn(tmp_path, corner(), name)}"\n'
                      f'[recording]\nfolder = "{tmp_path}/recording"\ncomplete = true\n')
    assert program("run", "--config", config).status == 0
    exported = program("recording", "export", tmp_path / "recording", "--out", tmp_path / "exported")
    assert "name it as mask.file" in exported.out
    assert len(json.loads((tmp_path / "exported/recording.json").read_text())["own_structure_sha256"]) == 64
    again = program("replay", "--config", tmp_path / "exported/config.toml", "--sequence", tmp_path / "exported", "--out", tmp_path / "again", *named(tmp_path / name))
    assert again.status == 0, again.err
    assert (tmp_path / "again/bus.ccsds").read_bytes() == (tmp_path / "run/bus.ccsds").read_bytes()
