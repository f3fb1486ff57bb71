#!/usr/bin/env -S python3 -Es -X utf8
"""Sets the estimator beside COLMAP over several sequences: a row each, ours as the median over seeds of the random draws."""

from polhode_ground.judge.peer_table import command

if __name__ == "__main__":
    command()
