"""Surface descriptions as plain arrays: what a renderer needs, with no renderer in it."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Material:
    """Principled surface. Images are float32, row 0 at v = 0; colours are sRGB-encoded in [0, 1].

    color (H, W, 3) or (3,); roughness and metallic (H, W) or a number; slopes (H, W, 2) are -dh/du, -dh/dv
    of the relief, or None for a smooth one.
    """

    color: object
    roughness: object = 0.5
    metallic: object = 0.0
    slopes: object = None
    clearcoat: float = 0.0
    specular: float = 0.5
    emission: float = 0.0
    extra: dict = field(default_factory=dict)


def normal_image(slopes):
    """Tangent-space normal map (H, W, 3) in [0, 1] from slopes."""
    n = np.concatenate([slopes, np.ones_like(slopes[..., :1])], axis=-1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return 0.5 + 0.5 * n


def slopes_from_height(height_px):
    """Slopes of a relief whose heights are in texels."""
    dv, du = np.gradient(height_px)
    return np.stack([-du, -dv], axis=-1).astype(np.float32)
