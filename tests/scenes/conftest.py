"""Makes the scene generator importable; its numerical parts need no Blender."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: renders with Blender, more than 20 s")
