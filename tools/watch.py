#!/usr/bin/env -S python3 -Es -X utf8
"""Shows a live run in a browser: image, camera and target in 3-D, rates, health, events."""

from polhode_ground.watching.watch import command

if __name__ == "__main__":
    command()
