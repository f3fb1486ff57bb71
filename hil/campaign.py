#!/usr/bin/env -S python3 -Es -X utf8
"""Runs a campaign: renders a plan's scenes, transforms and replays them, judges every run, and writes one report."""

from polhode_ground.campaigns.campaign import command

if __name__ == "__main__":
    command()
