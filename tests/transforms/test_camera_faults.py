"""Bad frames among good ones: the run goes on, no bad frame's pose is wrong, and the counters tell what happened."""

import pathlib
import subprocess

import numpy
import pytest
from polhode_ground.common.fault_log import LOG_FILE, read_log
from polhode_ground.common.sequence import read_sequence
from polhode_ground.judge.faulted import COUNTER_OF, judge_faulted
from polhode_ground.transforms.camera_faults import plan
from polhode_ground.transforms.table import transform

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = REPOSITORY / "build/release/bin/polhode"
SAMPLE = REPOSITORY / "hil/data/sample"


def test_plan_spoils_the_fraction_asked_for_in_equal_shares():
    for seed in range(5):
        faults = plan(300, 0.1, seed)
        assert len(faults) == 30 and min(faults) >= 2 and max(faults) < 299, "of the last frame nothing tells"
        assert all(list(faults.values()).count(kind) == 5 for kind in COUNTER_OF)
    assert plan(300, 0.1, 1) == plan(300, 0.1, 1) != plan(300, 0.1, 2)
    assert plan(300, 0.0, 1) == {}


@pytest.fixture(scope="module")
def spoiled(tmp_path_factory):
    """The sample with a third of its frames spoiled, and its log."""
    folder = tmp_path_factory.mktemp("faults") / "sequence"
    transform(SAMPLE, folder, [{"kind": "faults", "fraction": 0.35}], seed=4)
    return read_sequence(SAMPLE), folder, read_log(folder / LOG_FILE)


def test_the_log_says_what_was_done(spoiled):
    good, folder, log = spoiled
    bad = read_sequence(folder)
    assert len(log) == round(0.35 * len(good.timestamp_ns))
    kind_at = {one.timestamp_ns: one.kind for one in log}
    assert len(bad.timestamp_ns) == len(good.timestamp_ns) - sum(one.kind == "dropped" for one in log)
    before = None
    for index, stamp in enumerate(bad.timestamp_ns):
        gray = bad.read_gray(index)
        original = good.read_gray(int(numpy.flatnonzero(good.timestamp_ns == stamp)[0]))
        kind = kind_at.get(int(stamp))
        if kind is None:
            assert numpy.array_equal(gray, original)
        elif kind == "frozen":
            assert numpy.array_equal(gray, before)
        elif kind == "torn":
            of_before, of_now = (gray == before).all(axis=1), (gray == original).all(axis=1)
            assert (of_before | of_now).all() and 0.35 < of_before.mean() < 0.65
        elif kind == "dark":
            assert gray.mean() < 0.1 * original.mean() + 1e-9
        elif kind == "saturated":
            assert (gray == 255).sum() > 20 * (original == 255).sum()
        else:
            assert 0 < (gray != original).mean() < 0.2
        before = gray


# verifies: CMP-05
@pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.further)])
def test_a_tenth_of_bad_frames_does_no_harm(tmp_path, seed):
    transform(SAMPLE, tmp_path / "sequence", [{"kind": "faults"}], seed=seed)
    done = subprocess.run([PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence",
                           tmp_path / "sequence", "--out", tmp_path / "run"], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    verdict = judge_faulted(tmp_path / "run", read_sequence(tmp_path / "sequence"))
    assert verdict.wrong_poses == []
    assert verdict.coverage >= 0.95
    # One or two of each kind: within 5 % means exactly.
    assert {kind: verdict.counted[kind] for kind in COUNTER_OF} == {kind: verdict.injected[kind] for kind in COUNTER_OF}
