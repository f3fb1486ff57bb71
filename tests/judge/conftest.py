"""Makes the judge and the plots importable, and keeps matplotlib off any display."""

import os
import pathlib
import sys

os.environ["MPLBACKEND"] = "Agg"
os.environ["OPENBLAS_NUM_THREADS"] = "1"
REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
for folder in ("hil", "tools", "tests/judge", "platform/transport/client/python"):
    sys.path.insert(0, str(REPOSITORY / folder))
