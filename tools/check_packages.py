#!/usr/bin/env -S python3 -Es -X utf8
"""Checks the Debian packages of a folder without installing them, so those for another architecture, too."""

from polhode_ground.checking.check_packages import command

if __name__ == "__main__":
    command()
