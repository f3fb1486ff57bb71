#!/usr/bin/env -S python3 -Es -X utf8
"""Prints gcovr's summary of fsw by stage, as a table of Markdown, and the units whose branches are taken least (tools/coverage.sh)."""

from polhode_ground.checking.coverage_table import command

if __name__ == "__main__":
    command()
