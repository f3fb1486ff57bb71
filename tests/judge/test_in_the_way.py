"""Nothing of the user's is lost: each command that writes is called with files of others at its place and at names beside it."""

import os
import pathlib
import subprocess
import sys

import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.common.program import PROGRAM
from polhode_ground.common.whole_file import MARK, beside, claim_folder, write_whole
from polhode_ground.testing.synthetic import write_acquired

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
MINE = b"the user's own\n"
# Names that programs like to use for what is not ready yet.
BESIDE = ("{}.new", "{}.part", "{}.tmp", "{}~", ".{}.new", ".{}.tmp")

# command, arguments, what it writes; a folder ends with a slash
WRITING = [
    ("tools/import_sequence.py", ["PICTURES", "OUT/seq", "--rate-hz", "1", "--intrinsics", "60,60,31.5,23.5"], "OUT/seq/"),
    ("tools/report.py", ["RUN"], "RUN/report.html"),
    ("tools/report.py", ["RUN", "--out", "OUT/other.html", "--video", "OUT/run.mp4"], "OUT/run.mp4"),
    ("tools/report.py", ["RUN", "--out", "OUT/other.html", "--rrd", "OUT/run.rrd"], "OUT/run.rrd"),
    ("tools/plot_replay.py", ["RUN", "--out", "OUT"], "OUT/attitude_error.png"),
    ("tools/plot_masks.py", ["RUN", "SEQ", "--out", "OUT"], "OUT/overlay_000000.png"),
    ("tools/surface.py", ["RUN"], "RUN/surface.ply"),
    ("tools/sequence_to_mcap.py", ["SEQ", "--out", "OUT/run.mcap"], "OUT/run.mcap"),
    ("tools/calibrate_camera.py", ["--board", "chessboard", "--squares", "7x5", "--square-m", "0.1", "--out", "OUT/sensor.yaml", "PICTURES/0.png"],
     "OUT/sensor.yaml"),
    ("tools/calibrate_camera.py", ["--board", "chessboard", "--squares", "7x5", "--square-m", "0.1", "--out", "OUT/sensor.yaml", "PICTURES/0.png"],
     "OUT/sensor.png"),
    ("tools/scale_sequence.py", ["SEQ", "OUT/seq", "--width", "32", "--height", "24"], "OUT/seq/"),
    ("tools/generate_bus.py", ["--document", "OUT/bus.md"], "OUT/bus.md"),
    ("tools/make_site.py", ["--out", "OUT/site"], "OUT/site/source/conf.py"),
    ("tools/requirements_matrix.py", ["--pages", "OUT/pages"], "OUT/pages/image.md"),
    ("tools/sbom.py", ["--program", "SEQ/truth.csv", "--out", "OUT/bill.json"], "OUT/bill.json"),
    ("tools/export.py", ["RUN", "--format", "aem", "--out", "OUT/run.aem"], "OUT/run.aem"),
    ("tools/export.py", ["RUN", "--format", "ck", "--out", "OUT/run.bc"], "OUT/run.tf"),
    ("tools/export.py", ["RUN", "--format", "rosbag2", "--out", "OUT/bag"], "OUT/bag/"),
    ("hil/evaluate.py", ["RUN", "SEQ", "--json", "OUT/judged.json"], "OUT/judged.json"),
    ("hil/compare_colmap.py", ["SEQ", "--out", "OUT/peer"], "OUT/peer/images/picture.png"),
    ("hil/campaign.py", ["PLAN", "--out", "OUT/campaign"], "OUT/campaign/report/index.html"),
    ("hil/predict.py", ["SEQ", "OUT", "--frames", "5"], "OUT/sequence/mav0/cam0/data.csv"),
    ("hil/predict.py", ["SEQ", "OUT", "--frames", "5"], "OUT/run/motion.csv"),
    ("hil/transform.py", ["SEQ", "OUT/seq", "--kind", "jpeg"], "OUT/seq/"),
    ("hil/kill_campaign.py", ["OUT/kills"], "OUT/kills/"),
    ("hil/seu_campaign.py", ["OUT/flips"], "OUT/flips/"),
    ("PROGRAM", ["replay", "--config", "CONFIG", "--sequence", "SEQ", "--out", "OUT/run"], "OUT/run/motion.csv"),
    ("PROGRAM", ["recording", "export", "OUT", "--out", "OUT/seq"], "OUT/seq/"),
]
# What writes nothing, or only into the repository's own tree or a temporary folder, as its help says.
READING = {"tools/benchmark_table.py", "tools/check_budgets.py", "tools/check_packages.py", "tools/coverage_table.py", "tools/first_difference.py",
           "tools/golden.py", "tools/instruction_counts.py", "tools/junit_totals.py", "tools/other_processors.py", "tools/repeat_replays.py",
           "hil/peer_table.py", "tools/watch.py"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Words of the arguments and the places that they stand for."""
    folder = tmp_path_factory.mktemp("in_the_way")
    sequence, run = write_acquired(folder, frames=20)
    (run / "masks.pgms").write_bytes(b"P5\n# frame 0 used 1 behind 0 found 1 sharp 1 decimation 4\n4 4\n255\n" + bytes(16))
    (run / "mask_tracks.csv").write_text("frame\n")
    (folder / "pictures").mkdir()
    for number in range(3):
        Image.new("L", (64, 48), 40 * number).save(folder / f"pictures/{number}.png")
    (folder / "plan.toml").write_text(f'name = "plan"\nsequences = ["{sequence}"]\n')
    return {"SEQ": sequence, "PICTURES": folder / "pictures", "PLAN": folder / "plan.toml", "CONFIG": REPOSITORY / "config/default.toml", "RUN": run}


def files_of(*folders: pathlib.Path) -> dict[pathlib.Path, bytes]:
    return {pathlib.Path(place) / name: (pathlib.Path(place) / name).read_bytes() for folder in folders for place, _, names in os.walk(folder) for name in names}


def put_mine(place: pathlib.Path, is_folder: bool) -> None:
    file = place / "mine.txt" if is_folder else place
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(MINE)


def call(name: str, arguments: list[str], places: dict[str, pathlib.Path]):
    def placed(word: str) -> str:
        first, slash, rest = word.partition("/")
        return f"{places[first]}{slash}{rest}" if first in places else word
    command = [PROGRAM] if name == "PROGRAM" else [sys.executable, "-Es", "-X", "utf8", REPOSITORY / name]
    return subprocess.run([*command, *map(placed, arguments)], capture_output=True, text=True, timeout=120)


def test_each_command_is_known_to_write_or_not():
    commands = {f"{folder}/{file.name}" for folder in ("tools", "hil") for file in (REPOSITORY / folder).glob("*.py") if file.read_text().startswith("#!")}
    assert commands == READING | {name for name, _, _ in WRITING} - {"PROGRAM"}


@pytest.mark.parametrize(("name", "arguments", "written"), WRITING, ids=[f"{name}-{written}" for name, _, written in WRITING])
def test_what_is_in_the_way_stays(made, tmp_path, name, arguments, written):
    places = made | {"OUT": tmp_path / "out"}
    place = places[written.split("/")[0]] / written.partition("/")[2].rstrip("/")
    for kind in ("{}", *BESIDE):
        put_mine(place.with_name(kind.format(place.name)), written.endswith("/"))
    before = files_of(places["OUT"], places["RUN"], places["SEQ"])
    done = call(name, arguments, places)
    after = files_of(places["OUT"], places["RUN"], places["SEQ"])
    if written.startswith("RUN/"):
        for kind in ("{}", *BESIDE):
            place.with_name(kind.format(place.name)).unlink(missing_ok=True)
    assert done.returncode in (1, 2) and str(places[written.split("/")[0]]) in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert {file: after.get(file) for file in before} == before


@pytest.mark.parametrize(("name", "arguments", "written"), [WRITING[0], WRITING[7]], ids=["import", "mcap"])
def test_names_beside_the_place_are_nobodys_business(made, tmp_path, name, arguments, written):
    places = made | {"OUT": tmp_path / "out"}
    place = places["OUT"] / written.partition("/")[2].rstrip("/")
    for kind in BESIDE:
        put_mine(place.with_name(kind.format(place.name)), written.endswith("/"))
    before = files_of(tmp_path)
    for _ in range(1 if written.endswith("/") else 2):  # what the command itself has made it replaces
        done = call(name, arguments, places)
        assert done.returncode == 0, done.stderr
    after = files_of(tmp_path)
    assert {file: after.get(file) for file in before} == before
    assert {file.relative_to(tmp_path).parts[1] for file in after} - {file.relative_to(tmp_path).parts[1] for file in before} == {place.name}


def test_a_file_is_replaced_only_if_it_bears_the_mark(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(MINE)
    with pytest.raises(BadInput, match="is there already and was not made by this command"), beside(path) as part:
        part.write_text("new")
    assert path.read_bytes() == MINE and list(tmp_path.iterdir()) == [path]
    path.write_text("x" * 100_000 + MARK)  # at its end
    write_whole(path, "new", ours=False)
    assert path.read_text() == "new"
    path.write_bytes(MINE)
    write_whole(path, "new", ours=True)
    assert path.read_text() == "new"


def test_a_folder_is_filled_only_if_it_is_new_empty_or_ours(tmp_path):
    claim_folder(tmp_path / "new/folder", ".mark")
    claim_folder(tmp_path / "new/folder", ".mark")
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs/file").write_bytes(MINE)
    with pytest.raises(BadInput, match="holds other files"):
        claim_folder(tmp_path / "theirs", ".mark")
    claim_folder(tmp_path / "theirs", ".mark", "file")
    with pytest.raises(BadInput):
        claim_folder(tmp_path / "theirs/file", ".mark")
