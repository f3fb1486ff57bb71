#!/usr/bin/env -S python3 -Es -X utf8
"""Writes the poses of a run as flight dynamics, SPICE or ROS 2 read them."""

from polhode_ground.exporting.export import command

if __name__ == "__main__":
    command()
