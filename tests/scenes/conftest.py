"""The scene generator's numerical parts need no Blender."""


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: renders with Blender, more than 20 s")
