"""Prints gcovr's summary of fsw by stage, as a table of Markdown, and the units whose branches are taken least (tools/coverage.sh).

Example:
  tools/coverage_table.py build/coverage/coverage.json
"""

import argparse
import json
import pathlib

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import run_main

LEAST_PERCENT = 60  # of its branches: below, a unit is listed
FEW_BRANCHES = 10  # of a unit with less, one more or less is a tenth
COUNTS = ("line_covered", "line_total", "branch_covered", "branch_total")


def read_summary(file: pathlib.Path) -> dict[str, dict[str, int]]:
    """Counts by unit, as in map/track.cpp."""
    try:
        found = json.loads(file.read_text())["files"]
        return {one["filename"].removeprefix("fsw/"): {count: int(one[count]) for count in COUNTS} for one in found}
    except OSError as problem:
        raise BadInput(f"{file}: {problem.strerror}") from None
    except (ValueError, TypeError, KeyError):
        raise BadInput(f"{file}: not a summary of gcovr (--json-summary)") from None


def by_stage(units: dict[str, dict[str, int]]) -> dict[str, dict[str, int]]:
    stages: dict[str, dict[str, int]] = {}
    for unit, counts in sorted(units.items()):
        of_stage = stages.setdefault(unit.split("/")[0], dict.fromkeys(COUNTS, 0))
        for count in COUNTS:
            of_stage[count] += counts[count]
    return stages


def percent(covered: int, total: int) -> str:
    return f"{100 * covered / total:.1f}" if total else ""


def row(name: str, counts: dict[str, int]) -> str:
    lines = percent(counts["line_covered"], counts["line_total"])
    return f"| {name} | {lines} | {percent(counts['branch_covered'], counts['branch_total'])} | {counts['branch_total']} |"


def table(units: dict[str, dict[str, int]]) -> list[str]:
    stages = by_stage(units)
    total = {count: sum(counts[count] for counts in stages.values()) for count in COUNTS}
    least = sorted(
        (counts["branch_covered"] / counts["branch_total"], unit, counts)
        for unit, counts in units.items()
        if counts["branch_total"] >= FEW_BRANCHES and 100 * counts["branch_covered"] < LEAST_PERCENT * counts["branch_total"]
    )
    head = ["lines [%]", "branches [%]", "branches", ""]
    return [
        "| stage | " + " | ".join(head[:3]) + " |",
        "| --- | --- | --- | --- |",
        *(row(name, counts) for name, counts in stages.items()),
        row("all", total),
        "",
        f"| unit under {LEAST_PERCENT} % of its branches | " + " | ".join(head[:3]) + " |",
        "| --- | --- | --- | --- |",
        *(row(f"`fsw/{unit}`", counts) for _, unit, counts in least),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("summary", type=pathlib.Path, metavar="SUMMARY.json", help="of gcovr --json-summary")
    print("\n".join(table(read_summary(parser.parse_args().summary))))


def command() -> None:
    run_main(main, "coverage_table")
