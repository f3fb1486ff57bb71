#!/usr/bin/env -S python3 -Es -X utf8
"""The three budgets: builds what they need, replays the sample with each, and sets memory and accuracy beside the default's."""

from polhode_ground.checking.check_budgets import command

if __name__ == "__main__":
    command()
