"""Draws one random path: its flight, its body, its light, and what is done to its pictures on the way."""

import pathlib

import numpy as np

from polhode_ground.common.sequence import Camera
from polhode_ground.paths.boxes import picture, random_body
from polhode_ground.paths.flight import random_flight
from polhode_ground.transforms.footage import Footage, Shot, noisy, write_footage
from polhode_ground.transforms.table import KINDS, RESTAMPING, applied

FIRST_NS = 1_700_000_000_000_000_000
# They need a mesh, give a path another length, or came later: a new one would change what a seed draws.
NOT_FOR_PATHS = {"rolling_shutter", "mirrored", "excerpt", "rate_jump", "aspect", "zoom", "halves"}
STEPS_MAX = 2


def random_steps(rng: np.random.Generator, frames: int) -> list[dict]:
    """None to two transforms with options anywhere in the usual part of their ranges."""
    names = [name for name in KINDS if name not in NOT_FOR_PATHS]
    chosen = rng.choice(names, size=int(rng.integers(0, STEPS_MAX + 1)), replace=False)
    chosen = sorted((str(name) for name in chosen), key=lambda name: name not in RESTAMPING)
    if sum(name in RESTAMPING for name in chosen) > 1:
        chosen = chosen[:1]
    steps = []
    for name in chosen:
        step = {"kind": name}
        for option, table in KINDS[name].options.items():
            value = float(table.default) * 10 ** rng.uniform(-0.5, 0.5) if option not in ("from_part", "to_part") else table.default
            value = min(max(value, table.least), table.most)
            step[option] = max(int(value), int(table.least)) if isinstance(table.default, int) else value
        if name == "focal_length":
            step["factor"] = float(rng.uniform(0.7, 1.4))
        if name == "stale":
            step["age_frames"] = min(step["age_frames"], frames // 2)
        if name == "stamps":
            step["pace"] = float(rng.uniform(0.9, 1.1))
        steps.append(step)
    return steps


def _background(rng: np.random.Generator, camera: Camera) -> np.ndarray:
    """Radiance [H,W]: black, stars, or a lit ground."""
    shape, kind = (camera.height_px, camera.width_px), rng.choice(["none", "stars", "lit"], p=[0.5, 0.35, 0.15])
    if kind == "none":
        return np.zeros(shape)
    if kind == "stars":
        return np.where(rng.random(shape) < 0.002, rng.uniform(0.1, 1.0, shape), 0.0)
    v, u = np.mgrid[0 : shape[0], 0 : shape[1]] / shape[0]
    return 0.25 + 0.2 * np.sin(u * rng.uniform(2, 9) + rng.uniform(0, 6)) * np.sin(v * rng.uniform(2, 9))


def random_path(seed: list[int], frames: int, resolution: tuple[int, int]) -> tuple[Footage, list[dict]]:
    """(pictures with truth, the transforms to be applied to them). The same arguments give the same octets."""
    rng = np.random.default_rng([*seed, 1])
    width, height = resolution
    focal_px = width * float(10 ** rng.uniform(-0.1, 0.6))
    camera = Camera(width, height, np.array([focal_px, focal_px, (width - 1) / 2, (height - 1) / 2]), np.zeros(4))
    body, flight = random_body(rng), random_flight(rng, frames, 0.5 * height / focal_px)
    light = rng.normal(size=3) - [0, 0, 1.5]
    light_C, background, gain, noise = light / np.linalg.norm(light), _background(rng, camera), rng.uniform(120, 330), rng.uniform(0.5, 4.0)

    def pixels(frame: int) -> np.ndarray:
        radiance = picture(body, camera, flight.q_CT[frame], flight.p_CT[frame], light_C, background)
        return noisy(gain * radiance, noise, np.random.default_rng([*seed, 2, frame]))

    shots = [
        Shot(
            FIRST_NS + round(1e9 * flight.seconds[i]),
            lambda i=i: pixels(i),
            None,
            flight.q_CT[i],
            flight.p_CT[i],
            flight.v_C[i],
            flight.w_T[i],
            flight.q_IC[i] if flight.told else None,
        )
        for i in range(frames)
    ]
    period_s = float(flight.seconds[1] - flight.seconds[0])
    steps = random_steps(rng, frames)
    return Footage(camera, 1.0 / period_s, shots, None, {"path": {"seed": seed, "flight": flight.words, "steps": steps}}), steps


def draw_path(seed: list[int], frames: int, resolution: tuple[int, int], out: pathlib.Path) -> None:
    """Writes the sequence OUT, which is not there yet; BadInput as a transform says it."""
    footage, steps = random_path(seed, frames, resolution)
    write_footage(applied(footage, steps, seed[-1]), out)
