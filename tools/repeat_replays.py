#!/usr/bin/env -S python3 -Es -X utf8
"""One answer: replays of the same frames give the same bytes, whatever the machine does meanwhile."""

from polhode_ground.checking.repeat_replays import command

if __name__ == "__main__":
    command()
