#!/usr/bin/env -S python3 -Es -X utf8
"""Puts a sequence, the packets that belong to it and what a replay found into one MCAP file, as Foxglove reads it."""

from polhode_ground.exporting.sequence_to_mcap import command

if __name__ == "__main__":
    command()
