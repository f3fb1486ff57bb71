"""Requirements and tests name each other, in both directions, and so does the table of failures (tools/requirements_matrix.py)."""

import subprocess

import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.verification.catalogue import read_stage, read_stages
from polhode_ground.verification.requirements_matrix import all_faults, outcome, print_matrix, rows_of, write_pages
from polhode_ground.verification.tests import read_results, read_tests, result_of
from source_tree import REPOSITORY
from test_documents import SENTENCE_WORDS_MAX, sentences_of, words_of

TAG = "verifies" + ": "  # in two, or this file's own lines would be taken for tags
FEW, MANY = 60, 160  # fewer leave a stage out, more are read by nobody

STAGE = """# Map: poses

[MAP-01]
text = "A pose is found."
source = "decision 0007"
reason = "It is asked for."
method = "test"

[MAP-02]
text = "It is right."
source = "card: Frames and units"
reason = "It is used."
method = "analysis"
evidence = "docs/results.md"
"""
FILES = {
    "README.md": "## Frames and units\n",
    "docs/results.md": "",
    "docs/decisions/map.md": "- **One.** (0007)\n",
    "docs/requirements/06-map.toml": STAGE,
    "docs/fmea.md": "| failure | detection | answer | test |\n| --- | --- | --- | --- |\n| gone | mode | sought | `tests/map/pose_test.cpp::Pose.IsFound` |\n",
    "tests/map/pose_test.cpp": f"// {TAG}MAP-01\nTEST(Pose, IsFound) {{}}\n\nTEST_P(Pose,\n       IsOther) {{}}\n",
    "tests/live/test_pose.py": f"# {TAG}MAP-01, MAP-02\n@pytest.mark.slow\ndef test_it():\n    pass\n",
}


@pytest.fixture
def tree(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_requirements_and_tests_name_each_other():
    faults = all_faults(REPOSITORY)
    assert not faults, "\n".join(faults)


def test_there_are_requirements_of_every_stage_and_their_sentences_are_short():
    stages = read_stages(REPOSITORY)
    requirements = [one for stage in stages for one in stage.requirements]
    assert FEW <= len(requirements) <= MANY and all(len(stage.requirements) >= 3 for stage in stages)
    assert {"paper", "interfaces", "card", "decision"} <= {one.source.split()[0].strip(":") for one in requirements}
    wrong = [f"{one.identifier}: {sentence}" for one in requirements for sentence in sentences_of(f"{one.text}\n\n{one.reason}")
             if words_of(sentence) > SENTENCE_WORDS_MAX]
    assert not wrong, "\n".join(wrong)
    assert len({one.text for one in requirements}) == len(requirements)


WRONG = [
    ("tests/live/test_pose.py", ", MAP-02", "", "MAP-02 has no test"),
    ("tests/live/test_pose.py", "MAP-02", "MAP-09", "MAP-09 of tests/live/test_pose.py::test_it is no requirement"),
    ("tests/map/pose_test.cpp", "TEST(Pose, IsFound)", "\nTEST(Pose, IsFound)", "tests/map/pose_test.cpp:1: `verifies` stands above no test"),
    ("tests/map/pose_test.cpp", "IsFound", "IsLost", "docs/fmea.md: tests/map/pose_test.cpp::Pose.IsFound does not exist"),
    ("docs/fmea.md", "| mode ", "|  ", "docs/fmea.md: failure, detection, answer and a test: | gone"),
    ("docs/requirements/06-map.toml", "decision 0007", "decision 0008", "MAP-01: source decision 0008: allowed is"),
    ("docs/requirements/06-map.toml", "card: Frames and units", "card: Frames", "MAP-02: source card: Frames: allowed is"),
    ("docs/requirements/06-map.toml", "card: Frames and units", "hearsay", "MAP-02: source hearsay: allowed is"),
    ("docs/requirements/06-map.toml", "results.md", "gone.md", "MAP-02: analysis needs evidence"),
    ("docs/requirements/06-map.toml", '"analysis"', '"hope"', "MAP-02: method hope: allowed is test, analysis, inspection"),
    ("docs/requirements/06-map.toml", "[MAP-02]", "[MAP-2]", "MAP-2: three capitals, a dash and two digits are an id"),
    ("docs/requirements/06-map.toml", "[MAP-02]", "[POS-02]", "06-map: one set of three letters a file, not MAP, POS"),
]


def test_what_is_wrong_is_found(tree):
    assert all_faults(tree) == []
    assert read_tests(tree)[0] == {"tests/map/pose_test.cpp::Pose.IsFound": ["MAP-01"], "tests/map/pose_test.cpp::Pose.IsOther": [],
                                   "tests/live/test_pose.py::test_it": ["MAP-01", "MAP-02"]}
    for name, old, new, fault in WRONG:
        assert old in FILES[name]
        (tree / name).write_text(FILES[name].replace(old, new))
        assert any(fault in found for found in all_faults(tree)), fault
        (tree / name).write_text(FILES[name])


@pytest.mark.parametrize(("old", "new", "words"), [
    ('reason = "It is asked for."\n', "", "MAP-01: needs text, source, reason, method"),
    ('method = "test"', 'method = "test"\nowner = "x"', "owner"),
    ('"It is right."', "2", "MAP-02: not a table of texts"),
    ('"It is right."', "'", "06-map.toml: "),
    ("# Map: poses", "", "the first line is a comment"),
])
def test_a_file_that_is_none_is_refused(tree, old, new, words):
    file = tree / "docs/requirements/06-map.toml"
    file.write_text(STAGE.replace(old, new))
    with pytest.raises(BadInput, match=words):
        read_stage(file)


REPORT = """<testsuites><testsuite>
<testcase name="map.Pose.IsFound" status="run"/><testcase name="map.Worlds/Pose.IsOther/2" status="run"/>
<testcase name="map.Worlds/Pose.IsOther/3" status="fail"><failure/></testcase>
<testcase classname="tests.live.test_pose" name="test_it[a]"><skipped/></testcase>
</testsuite></testsuites>"""


def test_results_are_those_of_the_reports(tree, capsys):
    reports = tree / "reports"
    reports.mkdir()
    (reports / "one.xml").write_text(REPORT)
    results = read_results(reports)
    assert results == {"Pose.IsFound": "passed", "Pose.IsOther": "failed", "tests/live/test_pose.py::test_it": "skipped"}
    assert result_of("tests/map/other_test.cpp::Other.Test", results) == "not run"
    assert result_of("tests/site/test_site.py::test_it", results, {"tests/site/test_site.py::test_it"}) == "skipped"
    rows = rows_of(read_stages(tree), read_tests(tree)[0], results)
    assert [(one.identifier, result) for one, result, _ in rows] == [("MAP-01", "passed"), ("MAP-02", "skipped")]
    assert print_matrix(rows, results, only_open=True)
    said = capsys.readouterr().out
    assert "MAP-02  skipped  It is right." in said and "MAP-01" not in said
    assert "requirements: 2, 2 tests: 1 verified, 0 failed, 1 skipped here, 0 not run" in said
    assert outcome(["passed", "failed"]) == "failed" and outcome(["passed", "not run"]) == outcome([]) == "not run"
    assert not print_matrix(rows_of(read_stages(tree), read_tests(tree)[0], {"Pose.IsFound": "failed"}), results, only_open=False)


def test_pages_hold_all_that_is_stated(tree):
    write_pages(tree / "pages", read_stages(tree), rows_of(read_stages(tree), read_tests(tree)[0], {}))
    page = (tree / "pages/06-map.md").read_text()
    for words in ("# Map: poses", "## MAP-02", "It is right.", "- **Method:** analysis, `docs/results.md`", "`tests/live/test_pose.py::test_it`"):
        assert words in page


def test_the_command_prints_the_matrix():
    done = subprocess.run([REPOSITORY / "tools/requirements_matrix.py"], capture_output=True, text=True, timeout=60)
    assert done.returncode in (0, 1) and done.stderr == "", done.stderr  # 1: of the last run
    assert "MAP-01" in done.stdout and done.stdout.splitlines()[-1].startswith("requirements: ")
