"""From scene radiance to pixel values: exposure, full well, shot and read noise, response curve, quantisation.

Radiance is relative: a white matt surface that faces the sun has 1. All noise comes from a counter-based
generator keyed by the scene's seed and the frame's index, so a frame does not depend on those before it.
"""

from dataclasses import dataclass

import numpy as np

NOISE_STREAM = 77
LUMA = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)


@dataclass(frozen=True)
class Sensor:
    """exposure: share of the full well that radiance 1 fills. gamma 1 is a linear sensor."""

    exposure: float = 1.3
    full_well_e: float = 20000.0
    read_noise_e: float = 8.0
    gamma: float = 2.2
    bits: int = 8
    color: str = "gray"


def to_gray(radiance):
    """Luminance (H, W, 1) of linear RGB (H, W, 3)."""
    return (radiance @ LUMA)[..., None]


def response(signal, gamma):
    """Relative output for a relative signal in [0, 1], a power law with a straight foot as display curves have."""
    if gamma == 1.0:
        return signal
    # The foot ends where its slope equals the power law's, at a slope that keeps read noise below one step.
    foot, slope = 0.004, 6.0
    top = slope * foot
    x = np.clip((signal - foot) / (1 - foot), 0, 1)
    return np.where(signal < foot, slope * signal, top + (1 - top) * x ** (1 / gamma)).astype(np.float32)


def expose(radiance, sensor, scene_seed, frame_index):
    """Pixel values, (H, W) or (H, W, 3), uint8 or uint16, from linear RGB radiance (H, W, 3)."""
    signal = radiance if sensor.color == "rgb" else to_gray(radiance)
    electrons = np.clip(signal, 0, None) * (sensor.exposure * sensor.full_well_e)
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence([scene_seed, NOISE_STREAM, frame_index])))
    # Shot noise as a normal deviate: at the signals that matter (> 20 e) it differs from Poisson by less than one step.
    deviation = np.sqrt(electrons + sensor.read_noise_e**2, dtype=np.float32)
    electrons = electrons + deviation * rng.standard_normal(electrons.shape, dtype=np.float32)
    out = response(np.clip(electrons / sensor.full_well_e, 0, 1), sensor.gamma)
    top = 2**sensor.bits - 1
    image = np.floor(out * top + 0.5).astype(np.uint16 if sensor.bits == 16 else np.uint8)
    return image if sensor.color == "rgb" else image[..., 0]
