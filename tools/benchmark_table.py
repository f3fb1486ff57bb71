#!/usr/bin/env -S python3 -Es -X utf8
"""The cost of a replay from its summary.json, as a table."""

from polhode_ground.checking.benchmark_table import command

if __name__ == "__main__":
    command()
