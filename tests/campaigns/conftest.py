"""Makes campaigns, scenes and the made-up runs importable. What campaigns need beyond the judge is set up by tools/setup.sh campaign."""

import pathlib
import sys

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
for folder in ("hil", "hil/scenes", "tests/judge", "tests/campaigns"):
    sys.path.insert(0, str(REPOSITORY / folder))

for needed in ("distributed", "pyarrow"):
    pytest.importorskip(needed, reason=f"{needed} is not installed (tools/setup.sh campaign)")
