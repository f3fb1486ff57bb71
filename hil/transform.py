#!/usr/bin/env -S python3 -Es -X utf8
"""Makes a changed copy of a sequence, its truth kept right, and logs in OUT/faults.csv what was done to which frame."""

from polhode_ground.transforms.transform import command

if __name__ == "__main__":
    command()
