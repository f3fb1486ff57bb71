"""Makes the scene generator importable; its numerical parts need no Blender."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "hil" / "scenes"))


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: renders with Blender, more than 20 s")
