#!/usr/bin/env -S python3 -Es -X utf8
"""Makes a surface that follows the body's cloud, and puts it in the place of the convex hull: DIR/surface.ply."""

from polhode_ground.reporting.write_surface import command

if __name__ == "__main__":
    command()
