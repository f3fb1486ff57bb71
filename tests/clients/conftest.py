"""A replay's stream, as ground clients get it."""

import pathlib

import pytest
from flights import PROGRAM, damaged, flight

__all__ = ["damaged", "flight"]  # fixtures


def pytest_collection_modifyitems(items):
    here = pathlib.Path(__file__).parent
    if not PROGRAM.exists():
        for item in items:
            if here in item.path.parents and "flight" in item.fixturenames:
                item.add_marker(pytest.mark.skip(reason=f"{PROGRAM} is not built"))
