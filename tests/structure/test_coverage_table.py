"""The table of coverage that tools/coverage.sh ends with, from a made-up summary, and how both refuse what they cannot use."""

import json
import subprocess

import pytest
from polhode_ground.checking.coverage_table import read_summary, table
from polhode_ground.common.errors import BadInput
from source_tree import REPOSITORY


def counts(name, lines, line_total, branches, branch_total):
    return {"filename": f"fsw/{name}", "line_covered": lines, "line_total": line_total, "branch_covered": branches, "branch_total": branch_total}


def test_stages_are_added_up_and_the_least_units_named(tmp_path):
    file = tmp_path / "summary.json"
    file.write_text(json.dumps({"files": [counts("map/track.cpp", 90, 100, 30, 40), counts("map/grow.cpp", 10, 20, 5, 10),
                                          counts("map/small.cpp", 1, 2, 1, 4), counts("base/plain.cpp", 3, 3, 0, 0)]}))
    assert table(read_summary(file)) == [
        "| stage | lines [%] | branches [%] | branches |", "| --- | --- | --- | --- |",
        "| base | 100.0 |  | 0 |", "| map | 82.8 | 66.7 | 54 |", "| all | 83.2 | 66.7 | 54 |", "",
        "| unit under 60 % of its branches | lines [%] | branches [%] | branches |", "| --- | --- | --- | --- |",
        "| `fsw/map/grow.cpp` | 50.0 | 50.0 | 10 |"]


@pytest.mark.parametrize("text", ["", "[]", '{"files": [{"filename": "fsw/a.cpp"}]}', "{}"])
def test_what_is_no_summary_is_refused(tmp_path, text):
    (tmp_path / "summary.json").write_text(text)
    with pytest.raises(BadInput, match="not a summary of gcovr"):
        read_summary(tmp_path / "summary.json")


def test_an_unknown_stage_is_refused():
    done = subprocess.run([REPOSITORY / "tools/coverage.sh", "masks"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and done.stderr.startswith("coverage: unknown stage 'masks'; allowed: base geometry") and done.stderr.count("\n") == 1
