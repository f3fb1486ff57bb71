"""Which tests run beside which, and which only tools/run_further_tests.sh runs."""

import pathlib

import pytest

HERE = pathlib.Path(__file__).parent
# Runs with a clock, a port, a sealed memory or limits of the machine: one after another, beside tests of other folders.
ONE_BY_ONE = {"live", "memory", "budget"}


def pytest_collection_modifyitems(items):
    for item in items:
        folder = item.path.relative_to(HERE).parts[0]
        if folder in ONE_BY_ONE:
            item.add_marker(pytest.mark.xdist_group("machine"))
