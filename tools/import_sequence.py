#!/usr/bin/env -S python3 -Es -X utf8
"""Makes an image sequence, as `polhode replay` reads it, of what people have."""

from polhode_ground.importing.import_sequence import command

if __name__ == "__main__":
    command()
