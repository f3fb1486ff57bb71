#!/usr/bin/env -S python3 -Es -X utf8
"""Judges replay outputs against a sequence's truth, side by side."""

from polhode_ground.judge.evaluate import command

if __name__ == "__main__":
    command()
