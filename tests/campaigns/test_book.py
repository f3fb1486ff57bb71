"""Keys hold all that goes into a result, and what is run is what was hashed."""

import pathlib
import shutil

import pytest
from polhode_ground.campaigns.book import open_book
from polhode_ground.campaigns.plan import read_plan
from polhode_ground.campaigns.store import Store, folder_digest
from polhode_ground.common.errors import BadInput

PLAN = 'sequences = ["hil/data/sample"]\n[[configurations]]\nname = "default"\nfile = "{config}"\n[[transforms]]\nname = "coarse"\n' \
       'steps = [{{kind = "jpeg", quality = {quality}}}]\n[scenes]\ndraws = 1\nseed = {seed}\n[judge]\nshape = {shape}\n'


@pytest.fixture
def files(tmp_path):
    (tmp_path / "program").write_text("the program")
    (tmp_path / "config.toml").write_text("seed = 1\n")
    return tmp_path


def chains(files, quality=50, seed=1, shape="true"):
    plan = files / "plan.toml"
    plan.write_text(PLAN.format(config=files / "config.toml", quality=quality, seed=seed, shape=shape))
    return open_book(read_plan(plan), Store(files / "out", files / "cache"), files / "program")


def keys(some) -> dict[str, list[str]]:
    return {kind: [chain.task(kind).key for chain in some if chain.task(kind)] for kind in ("render", "transform", "replay", "judge")}


def test_the_same_is_the_same(files):
    assert keys(chains(files)) == keys(chains(files))


@pytest.mark.parametrize(("change", "kinds"), [
    (lambda files: (files / "program").write_text("another"), {"replay", "judge"}),
    (lambda files: (files / "config.toml").write_text("seed = 2\n"), {"replay", "judge"})])
def test_a_new_program_or_configuration_replays_and_keeps_scenes(files, change, kinds):
    before = keys(chains(files))
    change(files)
    after = keys(chains(files))
    assert {kind for kind in before if before[kind] != after[kind]} == kinds


@pytest.mark.parametrize(("changed", "kinds"), [({"shape": "false"}, {"judge"}), ({"quality": 51}, {"transform", "replay", "judge"}),
                                                ({"seed": 2}, {"render", "transform", "replay", "judge"})])
def test_a_new_question_changes_what_depends_on_it(files, changed, kinds):
    before, after = keys(chains(files)), keys(chains(files, **changed))
    assert {kind for kind in before if before[kind] != after[kind]} == kinds


def test_a_program_that_is_replaced_meanwhile_is_not_the_one_that_runs(files):
    replay = chains(files)[0].task("replay")
    (files / "program").write_text("built anew")
    (files / "config.toml").write_text("seed = 7\n")
    assert pathlib.Path(replay.options["program"]).read_text() == "the program"
    assert pathlib.Path(replay.options["config"]).read_text() == "seed = 1\n"


def test_a_sequence_behind_a_link_is_read_as_a_whole(tmp_path):
    real = tmp_path / "real"
    shutil.copytree(pathlib.Path(__file__).resolve().parents[2] / "hil/data/sample/mav0/cam0", real)
    (tmp_path / "seq/mav0").mkdir(parents=True)
    (tmp_path / "seq/mav0/cam0").symlink_to(real)
    before = folder_digest(tmp_path / "seq")
    (real / "sensor.yaml").write_text((real / "sensor.yaml").read_text() + "# edited\n")
    assert folder_digest(tmp_path / "seq") != before


def test_no_program_is_told(files):
    (files / "program").unlink()
    with pytest.raises(BadInput, match="not there or not a program"):
        chains(files)


def test_the_limit_is_asked_of_the_sequence_and_not_of_the_program(files, monkeypatch):
    from polhode_ground.campaigns import book
    monkeypatch.setattr(book, "LIMIT_PROGRAM", files / "limit")
    with pytest.raises(BadInput, match="tools/build.sh release builds it"):
        chains(files, shape="true\nlimit = true")
    (files / "limit").write_text("the tool")
    before = chains(files, shape="true\nlimit = true")[0]
    (files / "program").write_text("another")
    after = chains(files, shape="true\nlimit = true")[0]
    assert before.limit.place == after.limit.place and before.task("judge").place != after.task("judge").place
    assert [task.kind for task in before.missing][-2:] == ["judge", "limit"]
    assert chains(files)[0].limit is None


@pytest.mark.parametrize(("row", "limit", "late"), [
    ({"acquired": True, "first_pose_frame": 9}, {"frame": 4, "turn_deg": 8.0}, 5.0),
    ({"acquired": False, "first_pose_frame": None}, {"frame": 4, "turn_deg": 8.0}, float("inf")),
    ({"acquired": False, "first_pose_frame": None}, {"frame": None, "turn_deg": None}, None)])
def test_a_run_is_late_against_its_limit_only_where_there_is_one(row, limit, late):
    from polhode_ground.campaigns.results import _against_limit
    columns = _against_limit(row, limit)
    assert columns.get("first_pose_after_limit_frames") == late
    assert columns["decidable"] == (late is not None) and ("acquired_of_decidable" in columns) == (late is not None)
