"""Makes the judge and the plots importable, and keeps matplotlib off any display."""

import os
import pathlib

os.environ["MPLBACKEND"] = "Agg"
os.environ["OPENBLAS_NUM_THREADS"] = "1"
REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
