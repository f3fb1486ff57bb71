#!/usr/bin/env -S python3 -Es -X utf8
"""Runs COLMAP on a sequence, with the same intrinsics, and judges it beside a replay."""

from polhode_ground.judge.compare_colmap import command

if __name__ == "__main__":
    command()
