#!/usr/bin/env -S python3 -Es -X utf8
"""The first packet and field in which two bus streams differ."""

from polhode_ground.checking.first_difference import command

if __name__ == "__main__":
    command()
