"""The space of scenes that a campaign draws from: what varies, over which range, and the scene that a point of it means.

A draw is a point of a scrambled Sobol sequence, one coordinate for each dimension, so that few draws cover every range, and
more draws of the same seed begin with the same ones. Every draw becomes a scene table that renders alone.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import qmc

from polhode_ground.common.errors import BadInput


@dataclass(frozen=True)
class Range:
    """A number between two bounds, evenly or evenly in its logarithm."""

    least: float
    most: float
    logarithmic: bool = False

    def at(self, u: float) -> float:
        if self.logarithmic:
            return float(self.least * (self.most / self.least) ** u)
        return float(self.least + (self.most - self.least) * u)


@dataclass(frozen=True)
class Choice:
    """One of several names, by weight."""

    weights: dict[str, float]

    def at(self, u: float) -> str:
        names, weights = list(self.weights), np.array(list(self.weights.values()), dtype=float)
        return names[min(int(np.searchsorted(np.cumsum(weights) / weights.sum(), u, side="right")), len(names) - 1)]


# Dimensions of one block share a Sobol sequence. New ones go to the end: they make a block of their own, and the draws of
# today keep their coordinates.
FIRST_BLOCK = 41
SPACE = {
    "body": Choice({"cubesat": 0.45, "damaged_cube": 0.25, "upper_stage": 0.3}),
    "detail": Range(1, 1e6),  # seed of the body's detail
    "size_px": Range(70, 280, True),  # size_m in the picture, where the body is nearest
    "view_deg": Range(2, 14, True),  # the angle that it subtends there
    "motion": Choice({"tumble": 0.7, "spin": 0.22, "still": 0.08}),
    "turn_deg": Range(0.7, 9.0, True),  # rotation between frames
    "rate_deg_s": Range(0.2, 10.0, True),  # with turn_deg it gives the time between frames
    "inertia_least": Range(0.15, 0.85),  # least second moment over the largest
    "inertia_middle": Range(0.3, 1.0),  # the middle one, between the least and the largest
    "axes_deg": Range(0, 25),  # angle of the principal axes to the body's own
    "axes_clock_deg": Range(0, 360),
    "tilt_deg": Range(15, 75),  # of the angular velocity to the axis of largest inertia, in a tumble
    "tilt_clock_deg": Range(0, 360),
    "attitude_1": Range(0, 1),
    "attitude_2": Range(0, 1),
    "attitude_3": Range(0, 1),  # uniform over all attitudes
    "range_ratio": Range(0.6, 1.5, True),  # range at the end over range at the beginning
    "begin_off": Range(0, 1),
    "begin_clock_deg": Range(0, 360),  # place in the picture, part of what keeps the body in it
    "end_off": Range(0, 1),
    "end_clock_deg": Range(0, 360),
    "phase_deg": Range(20, 110),  # between the directions to the camera and to the sun, seen from the body
    "sun_clock_deg": Range(0, 360),
    "earthshine": Range(0.1, 0.5),
    "earth_deg": Range(45, 80),  # from the line of sight to the Earth's centre; its limb is at 67
    "earth_clock_deg": Range(0, 360),
    "background": Choice({"none": 0.35, "stars": 0.2, "earth": 0.3, "laboratory": 0.15}),
    "background_detail": Range(1, 1e6),
    "exposure": Range(0.6, 2.0, True),
    "full_well_e": Range(5000, 40000, True),
    "read_noise_e": Range(3, 20, True),
    "gamma": Choice({"2.2": 0.8, "1.0": 0.2}),
    "blur": Choice({"none": 0.5, "some": 0.5}),
    "blur_px": Range(0.3, 2.5),  # at the body's rim, where there is some
    "mass_off": Range(0, 0.12),  # centre of mass from the model's origin, part of the size
    "mass_clock_deg": Range(0, 360),
    "mass_height": Range(-1, 1),
    "camera": Choice({"fixed": 0.75, "turning": 0.25}),
    "camera_rate": Range(-0.5, 0.5),  # about the line of sight, part of the body's rate
    "distortion": Choice({"none": 0.5, "some": 0.5}),
    "distortion_px": Range(-6, 6),  # at the picture's corner
}
# Radius of a sphere about the middle that holds the body, over its size_m.
BODY_RADIUS = {"cubesat": 0.66, "damaged_cube": 0.92, "upper_stage": 0.62, "box": 0.87}
BODY_SIZE_M = {"cubesat": 1.0, "damaged_cube": 1.0, "upper_stage": 7.0, "box": 1.0}
LABORATORY_SIZE_M = 0.15
# Farther away the camera would stand outside of the room.
LABORATORY_VIEW_MIN_DEG = 9.0
# The room is lit for a camera that looks down by 10 deg.
LABORATORY_UP_C = (0.0, -0.9848077530, -0.1736481777)
MARGIN_PX = 6.0


@dataclass(frozen=True)
class Picture:
    """What all scenes of a plan share."""

    frames: int = 80
    resolution: tuple[int, int] = (640, 480)
    texture_px: int = 1024
    samples: int = 16


def narrowed(where: str, given: dict[str, Any]) -> dict[str, Any]:
    """SPACE with the plan's own ranges and weights; BadInput names the key and what is allowed."""
    space = dict(SPACE)
    for name, value in given.items():
        if name not in SPACE:
            raise BadInput(f"{where}.{name}: no such dimension; there are: {', '.join(SPACE)}")
        space[name] = _dimension(f"{where}.{name}", SPACE[name], value)
    return space


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and bool(np.isfinite(value))


def _dimension(where: str, default: Any, value: Any) -> Any:
    if isinstance(default, Choice):
        names = [*default.weights, "box"] if "cubesat" in default.weights else list(default.weights)
        if isinstance(value, str):
            value = {value: 1.0}
        if (
            not isinstance(value, dict)
            or not value
            or not set(value) <= set(names)
            or not all(_number(weight) and weight >= 0 for weight in value.values())
            or sum(value.values()) <= 0
        ):
            raise BadInput(f"{where}: allowed is one of {', '.join(names)}, or a table of their weights")
        return Choice(dict(value))
    if _number(value):
        value = [value, value]
    if not (isinstance(value, list) and len(value) == 2 and all(_number(x) for x in value) and value[0] <= value[1]):
        raise BadInput(f"{where}: allowed is a number, or [least, most]")
    if default.logarithmic and value[0] <= 0:
        raise BadInput(f"{where}: least = {value[0]}: must be positive")
    return replace(default, least=float(value[0]), most=float(value[1]))


def points(space: dict[str, Any], draws: int, seed: int) -> list[dict[str, Any]]:
    """The first `draws` points as {dimension: value}."""
    power = max(0, int(np.ceil(np.log2(max(draws, 1)))))
    blocks = [qmc.Sobol(FIRST_BLOCK, scramble=True, rng=np.random.default_rng(seed)).random_base2(power)]
    for extra in range(len(space) - FIRST_BLOCK):
        blocks.append(qmc.Sobol(1, scramble=True, rng=np.random.default_rng([seed, extra + 1])).random_base2(power))
    coordinates = np.hstack(blocks)[:draws]
    return [_feasible({name: dimension.at(u) for (name, dimension), u in zip(space.items(), row)}) for row in coordinates]


def _direction(angle_deg: float, clock_deg: float) -> np.ndarray:
    """Unit vector at an angle from +z, at a clock angle about it."""
    angle, clock = np.radians([angle_deg, clock_deg])
    return np.array([np.sin(angle) * np.cos(clock), np.sin(angle) * np.sin(clock), np.cos(angle)])


def _uniform_attitude(u1: float, u2: float, u3: float) -> list[float]:
    """Shoemake's map of a cube onto unit quaternions w, x, y, z (Graphics Gems III, 1992)."""
    a, b = 2 * np.pi * u2, 2 * np.pi * u3
    return _listed((np.sqrt(u1) * np.cos(b), np.sqrt(1 - u1) * np.sin(a), np.sqrt(1 - u1) * np.cos(a), np.sqrt(u1) * np.sin(b)))


def _inertia(p: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """(inertia tensor [3,3], largest moment 1; its axis of largest inertia [3]): second moments first, so that it is physical."""
    second = np.array([1.0, p["inertia_least"] + p["inertia_middle"] * (1 - p["inertia_least"]), p["inertia_least"]])
    clock = np.radians(p["axes_clock_deg"])
    axes = Rotation.from_rotvec(np.radians(p["axes_deg"]) * np.array([np.cos(clock), np.sin(clock), 0.0])).as_matrix()
    moments = second.sum() - second
    tensor = axes @ np.diag(moments / moments.max()) @ axes.T
    return 0.5 * (tensor + tensor.T), axes[:, int(np.argmax(moments))]


def _rate_T_deg_s(p: dict[str, Any], main_axis: np.ndarray) -> np.ndarray:
    if p["motion"] == "still":
        return np.zeros(3)
    across = np.cross(main_axis, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    tilt = p["tilt_deg"] if p["motion"] == "tumble" else 0.0
    axis = Rotation.from_rotvec(np.radians(tilt) * Rotation.from_rotvec(np.radians(p["tilt_clock_deg"]) * main_axis).apply(across))
    return np.asarray(p["rate_deg_s"] * axis.apply(main_axis))


def _places(p: dict[str, Any], focal_px: float, size_m: float, radius: float, picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Body's centre in C at the beginning and at the end [m]: all of it in the picture at both, hence between."""
    nearest_m = size_m / (2 * np.tan(np.radians(p["view_deg"]) / 2))
    begin_m = nearest_m / min(1.0, p["range_ratio"])
    ends = []
    for name, range_m in (("begin", begin_m), ("end", begin_m * p["range_ratio"])):
        radius_px = focal_px * radius * size_m / range_m
        width, height = picture.resolution
        # Within a circle, so that a camera that turns about its line of sight keeps it in view.
        free_px = max(0.0, 0.5 * min(width, height) - radius_px - MARGIN_PX)
        clock = np.radians(p[f"{name}_clock_deg"])
        off = np.sqrt(p[f"{name}_off"]) * free_px * np.array([np.cos(clock), np.sin(clock)])
        ends.append(range_m * np.array([off[0] / focal_px, off[1] / focal_px, 1.0]))
    return ends[0], ends[1]


def _light(p: dict[str, Any]) -> dict[str, Any]:
    """Sun and Earth, as directions from the target in C; the camera is at -z from it."""
    sun = _direction(180.0 - p["phase_deg"], p["sun_clock_deg"])
    return {
        "sun_direction_C": _listed(sun),
        "earth_direction_C": _listed(_direction(p["earth_deg"], p["earth_clock_deg"])),
        "earthshine": round(p["earthshine"], 4),
    }


def _listed(values: Iterable[float], digits: int = 9) -> list[float]:
    """Rounded: the last digits of sines and logarithms differ between processors, and scenes must not."""
    return [round(float(x), digits) for x in values]


def _feasible(p: dict[str, Any]) -> dict[str, Any]:
    """The room asks for a mock-up, near, before a camera that stands still."""
    if p["background"] != "laboratory":
        return p
    return p | {"body": "cubesat", "view_deg": max(p["view_deg"], LABORATORY_VIEW_MIN_DEG), "camera": "fixed"}


def scene_of(p: dict[str, Any], picture: Picture, name: str, seed: int) -> dict[str, Any]:
    """The scene table of a point of the space, as hil/scenes/README.md has it."""
    laboratory = p["background"] == "laboratory"
    size_m = LABORATORY_SIZE_M if laboratory else BODY_SIZE_M[p["body"]]
    focal_px = p["size_px"] / (2 * np.tan(np.radians(p["view_deg"]) / 2))
    period_s = p["turn_deg"] / p["rate_deg_s"]
    begin, end = _places(p, focal_px, size_m, BODY_RADIUS[p["body"]], picture)
    velocity = (end - begin) / (period_s * (picture.frames - 1))
    if laboratory:  # it slides over the table
        velocity -= np.dot(velocity, LABORATORY_UP_C) * np.array(LABORATORY_UP_C)
    inertia, main_axis = _inertia(p)
    clock = np.radians(p["mass_clock_deg"])
    across = np.sqrt(1 - p["mass_height"] ** 2)
    mass_off = p["mass_off"] * size_m * np.array([across * np.cos(clock), across * np.sin(clock), p["mass_height"]])
    width, height = picture.resolution
    scene: dict[str, Any] = {
        "name": name,
        "seed": seed,
        "target": {"kind": p["body"], "size_m": size_m, "detail_seed": int(p["detail"]), "texture_px": picture.texture_px},
        "motion": {
            "inertia_kg_m2": [_listed(row) for row in inertia],
            "w0_T_deg_s": _listed(_rate_T_deg_s(p, main_axis)),
            "q_CT0": _uniform_attitude(p["attitude_1"], p["attitude_2"], p["attitude_3"]),
            "p_CT0_m": _listed(begin),
            "v_C0_m_s": _listed(velocity),
            "centre_of_mass_G_m": _listed(mass_off),
        },
        "camera": {
            "resolution": [width, height],
            "intrinsics_px": [round(focal_px, 6), round(focal_px, 6), (width - 1) / 2, (height - 1) / 2],
        },
        "time": {"period_s": round(period_s, 9), "frames": picture.frames},
        "background": {"kind": p["background"], "seed": int(p["background_detail"])},
        "sensor": _sensor(p, period_s),
        "render": {"samples": picture.samples},
    }
    if p["distortion"] == "some":
        corner = np.hypot(width, height) / (2 * focal_px)
        scene["camera"]["distortion"] = [round(p["distortion_px"] / (focal_px * corner**3), 9), 0.0, 0.0, 0.0]
    if p["camera"] == "turning":
        scene["camera"]["w_C_deg_s"] = [0.0, 0.0, round(p["camera_rate"] * p["rate_deg_s"], 9)]
    if laboratory:
        scene["background"] |= {"up_C": list(LABORATORY_UP_C), "table_below_m": round(0.85 * size_m, 6)}
    else:
        scene["light"] = _light(p)
    return scene


def _sensor(p: dict[str, Any], period_s: float) -> dict[str, Any]:
    sensor = {
        "exposure": round(p["exposure"], 4),
        "full_well_e": round(p["full_well_e"], 1),
        "read_noise_e": round(p["read_noise_e"], 2),
        "gamma": float(p["gamma"]),
    }
    if p["blur"] == "some" and p["motion"] != "still":
        rim_px_s = np.radians(p["rate_deg_s"]) * p["size_px"] / 2
        sensor |= {"exposure_s": round(min(p["blur_px"] / rim_px_s, 0.5 * period_s), 9), "blur_samples": 3}
    return sensor
