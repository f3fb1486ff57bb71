#!/usr/bin/env -S python3 -Es -X utf8
"""Writes the bill of materials of a built program: CycloneDX 1.6, JSON."""

from polhode_ground.materials.sbom import command

if __name__ == "__main__":
    command()
