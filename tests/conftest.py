"""The files that take longest come first: no worker is left with one of them when the others have nothing more to do."""

import pathlib

HERE = pathlib.Path(__file__).parent
# Over a minute each, on two cores; the order is that of their time.
LONGEST = [HERE / name for name in (
    "structure/test_tidy.py", "campaigns/test_campaign.py", "replay/test_determinism.py", "memory/test_seal.py", "importing/test_guides.py",
    "scenes/test_rendering.py", "calibration/test_calibrate_camera.py", "live/test_signed_commands.py")]


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: LONGEST.index(item.path) if item.path in LONGEST else len(LONGEST))
