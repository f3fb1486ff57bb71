#!/usr/bin/env -S python3 -Es -X utf8
"""A sequence at another size, for measurements of cost: pictures are resampled and set in the middle of black."""

from polhode_ground.importing.scale_sequence import command

if __name__ == "__main__":
    command()
