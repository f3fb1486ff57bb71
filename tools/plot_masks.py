#!/usr/bin/env -S python3 -Es -X utf8
"""Draws over frames of a replay made with --masks what it took for the target."""

from polhode_ground.plots.plot_masks import command

if __name__ == "__main__":
    command()
