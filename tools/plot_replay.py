#!/usr/bin/env -S python3 -Es -X utf8
"""Draws what a replay found, as PNG files."""

from polhode_ground.plots.plot_replay import command

if __name__ == "__main__":
    command()
