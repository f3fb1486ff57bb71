#!/usr/bin/env -S python3 -Es -X utf8
"""Instructions that a frame costs, stage by stage: a measure of cost that no other load on the machine disturbs."""

from polhode_ground.checking.instruction_counts import command

if __name__ == "__main__":
    command()
