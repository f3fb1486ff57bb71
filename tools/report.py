#!/usr/bin/env -S python3 -Es -X utf8
"""Makes one page of a run that needs no other file: DIR/report.html."""

from polhode_ground.reporting.report import command

if __name__ == "__main__":
    command()
