#!/usr/bin/env -S python3 -Es -X utf8
"""Replays the first frames of a sequence and sets what they predict beside the truth of the rest."""

from polhode_ground.judge.predict import command

if __name__ == "__main__":
    command()
