#!/usr/bin/env -S python3 -Es -X utf8
"""The bus stream of the sample as this version is known to give it, for each architecture."""

from polhode_ground.checking.golden import command

if __name__ == "__main__":
    command()
