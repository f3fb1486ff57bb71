"""Plans are read whole or refused with file, key and what is allowed."""

import pytest
from polhode_ground.campaigns.plan import read_plan
from polhode_ground.campaigns.store import digest
from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY

SCENES = "[scenes]\ndraws = 2\nseed = 1\n"


def plan_of(tmp_path, text):
    path = tmp_path / "plan.toml"
    path.write_text(text)
    return read_plan(path)


def test_the_standing_set_is_24_scenes_in_two_configurations():
    plan = read_plan(REPOSITORY / "hil/campaigns/standing.toml")
    assert len(plan.scenes) == 24 and [setting.name for setting in plan.settings] == ["default", "full"] and len(plan.runs) == 48


def test_the_standing_set_stays_the_standing_set():
    """Its figures in docs/standing_set.md are of these very scenes: whoever changes them measures anew."""
    plan = read_plan(REPOSITORY / "hil/campaigns/standing.toml")
    assert digest(*[scene.text for scene in plan.scenes]) == "32a83cec30e9cdf434c1bf1448dbbe72"


@pytest.mark.parametrize("path", sorted((REPOSITORY / "hil/campaigns").glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_plans_can_be_read(path):
    if path.stem != "slurm_example":
        assert read_plan(path).runs


def test_runs_are_all_combinations_in_order(tmp_path):
    plan = plan_of(tmp_path, SCENES + """
[[configurations]]
name = "a"
file = "config/default.toml"
set = ["seed=5"]
[[configurations]]
name = "b"
file = "config/full.toml"
[sweep]
"map.keyframes_max" = [40, 60]
"seed" = [1, 2]
[[transforms]]
name = "coarse"
steps = [{kind = "jpeg", quality = 20}]
""")
    assert len(plan.runs) == 2 * 2 * 8
    assert [setting.name for setting in plan.settings][:2] == ["a+map.keyframes_max=40,seed=1", "a+map.keyframes_max=40,seed=2"]
    assert plan.settings[0].settings == ("seed=5", "map.keyframes_max=40", "seed=1")
    assert plan.settings[0].config == REPOSITORY / "config/default.toml"
    assert [transform.name for transform in plan.transforms] == ["plain", "coarse"]


def test_sequences_and_scene_files_are_taken_as_they_are(tmp_path):
    plan = plan_of(tmp_path, 'sequences = ["hil/data/sample"]\n[[scene_files]]\nfile = "hil/scenes/earth.toml"\nvariant = "small"\n')
    assert [scene.name for scene in plan.scenes] == ["earth_small", "sample"]
    assert plan.scenes[1].folder == REPOSITORY / "hil/data/sample"


@pytest.mark.parametrize(("text", "says"), [
    ("", "there is nothing to run"),
    ("[scenes]\ndraws = 0\nseed = 1\n", "scenes.draws: found 0, allowed is a whole number in 1 .. 4096"),
    ("[scenes]\nseed = 1\n", "scenes.draws: missing"),
    (SCENES + "frame = 3\n", "scenes.frame: unknown; allowed: draws, frames"),
    (SCENES + "resolution = [640]\n", "two whole numbers in 32 .. 4096"),
    (SCENES + "[scenes.space]\nturn_deg = -1\n", "scenes.space.turn_deg: least = -1: must be positive"),
    (SCENES + '[[configurations]]\nname = "x"\nfile = "config/none.toml"\n', "config/none.toml is neither beside the plan nor in the project"),
    (SCENES + '[[configurations]]\nfile = "config/full.toml"\n', "configurations 1.name: missing"),
    (SCENES + '[sweep]\nseed = 3\n', "sweep.seed: a list of values is needed"),
    (SCENES + '[sweep]\nmap.keyframes_max = [40]\n', "dotted keys stand in quotes"),
    (SCENES + '[[transforms]]\nname = "x"\nsteps = [{kind = "blur"}]\n', "transforms 1: kind 'blur' is none of"),
    (SCENES + '[[transforms]]\nname = "x"\nsteps = [{kind = "jpeg", quality = 200}]\n', "quality = 200: allowed is a whole number in 1 .. 100"),
    (SCENES + '[[transforms]]\nname = "plain"\nsteps = [{kind = "jpeg"}]\n', "two are called 'plain'"),
    (SCENES + '[[transforms]]\nname = "a/b"\nsteps = [{kind = "jpeg"}]\n', "'a/b' is no name"),
    ("untransformed = false\n" + SCENES, "untransformed is false: there is nothing to run"),
    (SCENES + "[judge]\nshape = 1\n", "judge.shape: found 1, allowed is true or false"),
    ('sequences = ["hil/scenes"]\n', "holds no mav0/cam0/data.csv"),
    (SCENES + '[sweep]\n"seed" = [2020-01-01]\n', "sweep.seed: values are numbers, texts"),
    (SCENES + '[[configurations]]\nname = "x"\nfile = "config"\n', "Is a directory"),
    ('[[scene_files]]\nfile = "README.md"\n', "not TOML"),
    (SCENES + '[[transforms]]\nname = "x"\nsteps = [{kind = "torn"}, {kind = "stamps"}]\n', "it must be the first step"),
    ("sequences = 3\n", "allowed is a list"),
    ("this is no plan", "not TOML"),
])
def test_what_is_no_plan_is_refused(tmp_path, text, says):
    with pytest.raises(BadInput) as refused:
        plan_of(tmp_path, text)
    assert says in str(refused.value) and "plan.toml" in str(refused.value)
