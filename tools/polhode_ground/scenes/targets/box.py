"""A dark matt box: the plainest target, for tests of geometry."""

from .. import mesh
from ..materials import Material


def build(size_m, detail_seed, texture_px):
    """Parts, materials and no known lengths. The cube has edges of size_m and its centre at G's origin."""
    del detail_seed, texture_px
    half = size_m / 2
    return (
        [mesh.box("box", [-half] * 3, [half] * 3, "dark", 0.01 * size_m)],
        {"dark": Material((0.2, 0.2, 0.2), 0.8)},
        [],
    )
