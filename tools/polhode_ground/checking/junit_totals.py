"""Adds up JUnit reports and prints the one closing line of a test run: N passed, N failed, N skipped.

Examples:
  tools/junit_totals.py build/test-reports/*.xml
"""

import argparse
import xml.etree.ElementTree as ElementTree

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import run_main


def totals(report: str) -> tuple[int, int, int]:
    passed = failed = skipped = 0
    try:
        root = ElementTree.parse(report).getroot()
    except OSError as problem:
        raise BadInput(f"{report}: {problem.strerror}") from None
    except ElementTree.ParseError as problem:
        raise BadInput(f"{report}: not a report: {problem}") from None
    for case in root.iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail":
            failed += 1
        elif case.find("skipped") is not None or case.get("status") in ("notrun", "disabled"):
            skipped += 1
        else:
            passed += 1
    return passed, failed, skipped


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status 0: some passed and none failed; 1: not so; 2: a report cannot be read.",
    )
    parser.add_argument("reports", metavar="REPORT.xml", nargs="+")
    passed, failed, skipped = (sum(column) for column in zip(*map(totals, parser.parse_args().reports)))
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return 1 if failed or not passed else 0


def command() -> None:
    run_main(main, "junit_totals")
