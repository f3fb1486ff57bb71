"""Each assertion of fsw is judged: what could reach it, and why that does not fail it (docs/assertions.md)."""

import collections
import pathlib
import re

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
DOCUMENT = REPOSITORY / "docs/assertions.md"


def asserting_functions() -> dict[str, int]:
    """Assertions by file, relative to fsw."""
    found = {}
    for file in sorted((REPOSITORY / "fsw").rglob("*.[ch]pp")):
        count = len(re.findall(r"^\s*POLHODE_ASSERT\(", file.read_text(), re.MULTILINE))
        if count:
            found[file.relative_to(REPOSITORY / "fsw").as_posix()] = count
    return found


def rows() -> collections.Counter:
    """Rows by file."""
    found, room = collections.Counter(), None
    for line in DOCUMENT.read_text().splitlines():
        if line.startswith("## `fsw/"):
            room = line.split("`")[1].removeprefix("fsw/")
        elif room and line.startswith("| ") and not line.startswith(("| place", "| ---")):
            found[f"{room}/{line.split()[1].rstrip(',')}"] += 1
    return found


def test_each_file_with_assertions_has_a_row_for_each():
    judged = rows()
    missing = {file: (count, judged[file]) for file, count in asserting_functions().items() if judged[file] < count}
    assert not missing, f"(assertions, rows): {missing}"
    assert not {file for file in judged if file not in asserting_functions()}, "rows of files without an assertion"
