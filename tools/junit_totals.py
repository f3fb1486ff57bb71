#!/usr/bin/env python3
"""Adds up JUnit reports and prints the one closing line of a test run: N passed, N failed, N skipped."""

import sys
import xml.etree.ElementTree as ElementTree


def totals(report: str) -> tuple[int, int, int]:
    passed = failed = skipped = 0
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail":
            failed += 1
        elif case.find("skipped") is not None or case.get("status") in ("notrun", "disabled"):
            skipped += 1
        else:
            passed += 1
    return passed, failed, skipped


if __name__ == "__main__":
    passed, failed, skipped = (sum(column) for column in zip(*map(totals, sys.argv[1:])))
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    sys.exit(1 if failed or not passed else 0)
