#!/usr/bin/env -S python3 -Es -X utf8
"""Adds up JUnit reports and prints the one closing line of a test run: N passed, N failed, N skipped."""

from polhode_ground.checking.junit_totals import command

if __name__ == "__main__":
    command()
