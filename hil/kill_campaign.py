#!/usr/bin/env -S python3 -Es -X utf8
"""Kills a live run at random moments and starts it anew, as a service manager would."""

from polhode_ground.faults.kill_campaign import command

if __name__ == "__main__":
    command()
