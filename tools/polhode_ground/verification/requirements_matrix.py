"""Requirements beside the tests that verify them: docs/requirements/*.toml and the tags `verifies: ID` above tests.

Prints a line a requirement and a line a test, with the result of the last tools/run_tests.sh. Found wrong are: a requirement without a
test, a tag without a requirement, a source that is not there, a row of docs/fmea.md whose test does not exist.
"""

import argparse
import pathlib
import re
import sys

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY, run_main
from polhode_ground.verification.catalogue import Requirement, Stage, faults_of, read_stages
from polhode_ground.verification.tests import further_tests, read_results, read_tests, result_of

EPILOG = """Exit status 0: all is as it should be; 1: something is wrong, or a requirement's tests have failed or were not run; 2: unusable input.
A requirement is verified when one of its tests has passed, none has failed, and the others were skipped with a reason. Where no report is, nothing is said of results.

Examples:
  tools/requirements_matrix.py --check
  tools/requirements_matrix.py --open"""
TEST_IN_TABLE = re.compile(r"`(tests/[^`]+::[^`]+)`")


def verified_by(tests: dict[str, list[str]]) -> dict[str, list[str]]:
    """Tests by requirement."""
    found: dict[str, list[str]] = {}
    for test, identifiers in tests.items():
        for identifier in identifiers:
            found.setdefault(identifier, []).append(test)
    return found


def fmea_faults(repository: pathlib.Path, tests: dict[str, list[str]]) -> list[str]:
    """Rows of the table: failure, detection, answer, test."""
    file = repository / "docs/fmea.md"
    rows = [line for line in file.read_text().splitlines() if line.startswith("|")] if file.is_file() else []
    rows = [row for row in rows if not row.startswith("| ---") and not row.startswith("| failure |")]
    faults = [] if rows else ["docs/fmea.md: no row"]
    for row in rows:
        cells = [cell.strip() for cell in row.strip("|").split(" | ")]
        named = TEST_IN_TABLE.findall(cells[-1])
        if len(cells) != 4 or not all(cells) or not named:
            faults.append(f"docs/fmea.md: failure, detection, answer and a test: {row[:60]}")
        faults += [f"docs/fmea.md: {test} does not exist" for test in named if test not in tests]
    return faults


def all_faults(repository: pathlib.Path) -> list[str]:
    stages = read_stages(repository)
    tests, faults = read_tests(repository)
    known = {one.identifier for stage in stages for one in stage.requirements}
    tagged = verified_by(tests)
    faults += faults_of(stages, repository)
    faults += [f"{identifier} has no test" for identifier in sorted(known - set(tagged))]
    faults += [f"{identifier} of {tagged[identifier][0]} is no requirement" for identifier in sorted(set(tagged) - known)]
    return faults + fmea_faults(repository, tests)


def outcome(results: list[str]) -> str:
    """Of a requirement, from its tests."""
    return next((result for result in ("failed", "not run", "passed", "skipped") if result in results), "not run")


def rows_of(
    stages: list[Stage], tests: dict[str, list[str]], results: dict[str, str], further: frozenset[str] | set[str] = frozenset()
) -> list[tuple[Requirement, str, list[tuple[str, str]]]]:
    """@return for each requirement its outcome, and its tests with their results."""
    tagged = verified_by(tests)
    rows = []
    for stage in stages:
        for one in stage.requirements:
            with_results = [(test, result_of(test, results, further)) for test in tagged.get(one.identifier, [])]
            rows.append((one, outcome([result for _, result in with_results]), with_results))
    return rows


def print_matrix(rows, results: dict[str, str], only_open: bool) -> bool:
    """@return whether each requirement is verified, or could not be on this machine."""
    for one, result, with_results in rows:
        if only_open and result == "passed":
            continue
        print(f"{one.identifier}  {result if results else '':7}  {one.text}")
        print(f"         {one.method:10}  {one.source}{', ' + one.evidence if one.evidence else ''}")
        for test, of_test in with_results:
            print(f"         {of_test if results else '':10}  {test}")
    counts = {word: sum(result == word for _, result, _ in rows) for word in ("passed", "failed", "skipped", "not run")}
    tests = len({test for _, _, with_results in rows for test, _ in with_results})
    said = (
        f": {counts['passed']} verified, {counts['failed']} failed, {counts['skipped']} skipped here, {counts['not run']} not run"
        if results
        else ""
    )
    print(f"requirements: {len(rows)}, {tests} tests{said}")
    return not (results and (counts["failed"] or counts["not run"]))


def write_pages(folder: pathlib.Path, stages: list[Stage], rows) -> None:
    """One page of Markdown a stage, as tools/site.sh shows them."""
    folder.mkdir(parents=True, exist_ok=True)
    by_identifier = {row[0].identifier: row for row in rows}
    for stage in stages:
        lines = [f"# {stage.title}"]
        for one in stage.requirements:
            _, _, with_results = by_identifier[one.identifier]
            lines += [
                "",
                f"## {one.identifier}",
                one.text,
                "",
                f"- **Reason:** {one.reason}",
                f"- **Source:** {one.source}",
                f"- **Method:** {one.method}" + (f", `{one.evidence}`" if one.evidence else ""),
            ]
            lines += [f"- **Test:** `{test}`" for test, _ in with_results]
        (folder / f"{stage.name}.md").write_text("\n".join(lines) + "\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="print only what is wrong with requirements, tags and docs/fmea.md")
    parser.add_argument("--open", action="store_true", help="leave out what is verified")
    parser.add_argument("--results", type=pathlib.Path, metavar="FOLDER", help="reports of JUnit; default: build/test-reports")
    parser.add_argument("--pages", type=pathlib.Path, metavar="FOLDER", help="write pages of Markdown instead")
    arguments = parser.parse_args()
    if arguments.results and not arguments.results.is_dir():
        raise BadInput(f"{arguments.results}: no such folder")
    faults = all_faults(REPOSITORY)
    if faults:
        print("\n".join(faults), file=sys.stderr)
        return 1
    if arguments.check:
        return 0
    stages, (tests, _) = read_stages(REPOSITORY), read_tests(REPOSITORY)
    results = read_results(arguments.results or REPOSITORY / "build/test-reports")
    rows = rows_of(stages, tests, results, further_tests(REPOSITORY))
    if arguments.pages:
        from polhode_ground.common.whole_file import claim_folder

        claim_folder(arguments.pages, ".polhode-pages")
        write_pages(arguments.pages, stages, rows)
        return 0
    return 0 if print_matrix(rows, results, arguments.open) else 1


def command() -> None:
    run_main(main, "requirements_matrix")
