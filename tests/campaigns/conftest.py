"""What campaigns need beyond the judge is set up by tools/setup.sh campaign."""

import pytest

for needed in ("distributed", "pyarrow"):
    pytest.importorskip(needed, reason=f"{needed} is not installed (tools/setup.sh campaign)")
