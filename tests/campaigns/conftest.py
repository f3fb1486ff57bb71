"""Makes campaigns, scenes and the made-up runs importable. What campaigns need beyond the judge is set up by tools/setup.sh campaign."""

import pathlib

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

for needed in ("distributed", "pyarrow"):
    pytest.importorskip(needed, reason=f"{needed} is not installed (tools/setup.sh campaign)")
