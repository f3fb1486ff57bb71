#!/usr/bin/env -S python3 -Es -X utf8
"""Calibrates a camera from pictures or a video of a chessboard or ChArUco board."""

from polhode_ground.calibration.calibrate_camera import command

if __name__ == "__main__":
    command()
