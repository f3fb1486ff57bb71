"""Makes the transforms importable."""

import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
for folder in ("hil", "tests/transforms"):
    sys.path.insert(0, str(REPOSITORY / folder))
