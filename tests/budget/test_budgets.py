"""The configurations of the three budgets: admitted where they fit, refused where they do not. Their runs: tools/check_budgets.py."""

import math
import os
import pathlib
import re
import subprocess

import pytest
from polhode_ground.checking import check_budgets

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))


pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")
FOUND = {"resident": 60, "allowed": 64, "overdrawn": 0, **dict.fromkeys(check_budgets.MEASURES, 1.0)}


def check(tmp_path, budget: str, width: int, height: int):
    config = tmp_path / "config.toml"
    config.write_text((REPOSITORY / f"config/{budget}.toml").read_text() + f"""
[camera]
width_px = {width}
height_px = {height}
fu_px = {width}.0
fv_px = {width}.0
cu_px = {width / 2}
cv_px = {height / 2}
""")
    return subprocess.run([PROGRAM, "check", "--config", config, "--memory"], capture_output=True, text=True)


# verifies: RES-03
@pytest.mark.parametrize("budget, width, height", [("standard", 1280, 720), ("full", 1920, 1080)])
def test_a_budget_holds_its_camera(tmp_path, budget, width, height):
    result = check(tmp_path, budget, width, height)
    assert result.returncode == 0, result.stderr
    assert "It fits." in result.stdout


# verifies: RES-03
@pytest.mark.parametrize("budget, width, height", [("standard", 3840, 2160), ("full", 7680, 4320)])
def test_a_larger_camera_is_refused(tmp_path, budget, width, height):
    result = check(tmp_path, budget, width, height)
    assert result.returncode == 2
    assert "does not fit" in result.stderr


# verifies: RES-03
def test_the_standard_tables_are_too_large_for_the_small_budget(tmp_path):
    result = check(tmp_path, "small", 640, 480)
    assert result.returncode == 2
    assert "budget.total_mb" in result.stderr


def test_promises_that_are_kept_are_not_reproached():
    assert check_budgets.verdicts("small", FOUND, FOUND) == []


@pytest.mark.parametrize("broken", [{"resident": 65}, {"overdrawn": 1}, {"causal attitude [deg]": 1.6}])
def test_each_broken_promise_is_named(broken):
    assert len(check_budgets.verdicts("small", {**FOUND, **broken}, FOUND)) == 1


def test_both_sets_of_tables_have_the_same_limits_and_the_small_ones_are_no_larger():
    def limits(path: str) -> dict[str, int]:
        """By name; a factor of one limit may be another that stands before it."""
        values: dict[str, int] = {}
        for name, product in re.findall(r"size_t (k\w+) = ([\w *]+);", (REPOSITORY / path).read_text()):
            values[name] = math.prod(values[f] if f in values else int(f) for f in product.split(" * "))
        return values

    standard, small = limits("config/limits.hpp"), limits("config/small/config/limits.hpp")
    assert list(standard) == list(small)
    assert all(small[name] <= standard[name] for name in standard)
