#!/usr/bin/env -S python3 -Es -X utf8
"""The sample's bus stream on processors that this machine has not: replayed under QEMU and compared with what is recorded."""

from polhode_ground.checking.other_processors import command

if __name__ == "__main__":
    command()
