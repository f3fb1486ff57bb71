#!/usr/bin/env -S python3 -Es -X utf8
"""Draws over frames of a replay made with --masks what it took for the target: the target's outline (blue), where no features may be made (darkened), points that the mask followed and landmarks by class (green: target, red: background, yellow: unassigned)."""

from polhode_ground.plots.plot_masks import command

if __name__ == "__main__":
    command()
