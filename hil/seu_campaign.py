#!/usr/bin/env -S python3 -Es -X utf8
"""Flips bits in the tables of a live run at drawn frames, as radiation does, and tells what came of it."""

from polhode_ground.faults.seu_campaign import command

if __name__ == "__main__":
    command()
