"""Which tests there are, which requirements they say they verify, and how they went.

A tag is a comment in the line above a test: `// verifies: MAP-03, MAP-04` above TEST(...), `# verifies: LIV-01` above a function
of pytest and its decorators. A test is named as FILE::Suite.Name or FILE::test_name, from the repository's top folder."""

import ast
import pathlib
import re
import xml.etree.ElementTree as ElementTree

from polhode_ground.common.errors import BadInput

TAG = re.compile(r"^\s*(?://|#) verifies: (.*)$")
CPP_TEST = re.compile(r"^TEST\w*\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)
CASE_OF_GTEST = re.compile(r"[\w-]+\.(?:[^/]+/)?(\w+)\.(\w+)(?:/.*)?")  # folder.[Instance/]Suite.Name[/parameter]


def tests_of_cpp(text: str) -> dict[int, str]:
    """Line of each test, from 0: its name."""
    return {text.count("\n", 0, test.start()): f"{test[1]}.{test[2]}" for test in CPP_TEST.finditer(text)}


def tests_of_python(text: str) -> dict[int, str]:
    """Line of each test or of its first decorator, from 0: its name."""
    return {
        min([node.lineno] + [decorator.lineno for decorator in node.decorator_list]) - 1: node.name
        for node in ast.parse(text).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def is_further(node: ast.AST) -> bool:
    return any(isinstance(part, ast.Attribute) and part.attr == "further" for part in ast.walk(node))


def further_tests(repository: pathlib.Path) -> set[str]:
    """Tests that tools/run_further_tests.sh runs alone: with the mark `further`, their own or their file's."""
    found = set()
    for file in sorted((repository / "tests").rglob("test_*.py")):
        body = ast.parse(file.read_text()).body
        all_are = any(
            isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "pytestmark" and is_further(node) for node in body
        )
        found |= {
            f"{file.relative_to(repository).as_posix()}::{node.name}"
            for node in body
            if isinstance(node, ast.FunctionDef) and (all_are or any(map(is_further, node.decorator_list)))
        }
    return found


def read_tests(repository: pathlib.Path) -> tuple[dict[str, list[str]], list[str]]:
    """@return ids by test, for all tests; what is wrong with the tags."""
    found, faults = {}, []
    files = sorted((repository / "tests").rglob("*_test.cpp")) + sorted((repository / "tests").rglob("test_*.py"))
    for file in files:
        text = file.read_text()
        name = file.relative_to(repository).as_posix()
        tests = (tests_of_cpp if file.suffix == ".cpp" else tests_of_python)(text)
        lines = text.splitlines()
        for line, test in tests.items():
            tag = TAG.match(lines[line - 1]) if line else None
            found[f"{name}::{test}"] = [word.strip() for word in tag[1].split(",")] if tag else []
        faults += [
            f"{name}:{line + 1}: `verifies` stands above no test"
            for line, text in enumerate(lines)
            if TAG.match(text) and line + 1 not in tests
        ]
    return found, faults


def case_of(case: ElementTree.Element) -> str:
    """A key that is the same for a test and for all of its parameters: file::name of pytest, Suite.Name of gtest."""
    name, place = case.get("name", ""), case.get("classname", "")
    if place.startswith("tests."):
        return f"{place.replace('.', '/')}.py::{name.partition('[')[0]}"
    gtest = CASE_OF_GTEST.fullmatch(name)
    return f"{gtest[1]}.{gtest[2]}" if gtest else name


def read_results(folder: pathlib.Path) -> dict[str, str]:
    """By key of case_of: failed, passed or skipped; the first of these that one of its parameters had."""
    results: dict[str, str] = {}
    for file in sorted(folder.glob("*.xml")):
        try:
            root = ElementTree.parse(file).getroot()
        except ElementTree.ParseError as problem:
            raise BadInput(f"{file}: not a report: {problem}") from None
        for case in root.iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail":
                result = "failed"
            elif case.find("skipped") is not None or case.get("status") in ("notrun", "disabled"):
                result = "skipped"
            else:
                result = "passed"
            key = case_of(case)
            results[key] = min(result, results.get(key, result))  # in alphabetical order
    return results


def result_of(test: str, results: dict[str, str], further: frozenset[str] | set[str] = frozenset()) -> str:
    file, _, name = test.partition("::")
    return results.get(test if file.endswith(".py") else name, "skipped" if test in further else "not run")
