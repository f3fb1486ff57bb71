"""The scene file: TOML with one table per subject, every key known, every value checked before rendering."""

import copy
import hashlib
import tomllib
from pathlib import Path

import numpy as np

TARGET_KINDS = ("cubesat", "damaged_cube", "upper_stage", "file", "box")
BACKGROUNDS = ("none", "stars", "earth", "laboratory")


class SceneError(Exception):
    """A scene that cannot be rendered; the message is one line that says where and why."""


def _vector(n):
    return ("vector", n)


# table -> key -> (kind, default); a default of None means required, "" means optional without a value.
SCHEMA = {
    "": {"name": (str, "scene"), "seed": (int, 1)},
    "target": {
        "kind": (str, None),
        "size_m": (float, 1.0),
        "detail_seed": (int, 1),
        "texture_px": (int, 2048),
        "panel_length_m": (float, ""),
        "path": (str, ""),
        "scale": (float, 1.0),
        "fiducials_G_m": ("points", []),
        "fiducial_radius_m": (float, 0.01),
    },
    "motion": {
        "inertia_kg_m2": ("inertia", None),
        "w0_T_deg_s": (_vector(3), None),
        "q_CT0": (_vector(4), None),
        "p_CT0_m": (_vector(3), None),
        "v_C0_m_s": (_vector(3), [0.0, 0.0, 0.0]),
        "centre_of_mass_G_m": (_vector(3), [0.0, 0.0, 0.0]),
        "translation": (str, "constant"),
        "mean_motion_rad_s": (float, 0.0011),
        "q_CH0": (_vector(4), [1.0, 0.0, 0.0, 0.0]),
    },
    "camera": {
        "resolution": (_vector(2), [1920, 1080]),
        "lens_mm": (float, 50.0),
        "sensor_width_mm": (float, 36.0),
        "intrinsics_px": (_vector(4), ""),
        "distortion": (_vector(4), [0.0, 0.0, 0.0, 0.0]),
        "w_C_deg_s": (_vector(3), [0.0, 0.0, 0.0]),
        "attitude_history": ("history", []),
    },
    "time": {
        "start_s": (float, 0.0),
        "period_s": (float, 10.0),
        "frames": (int, 300),
        "epoch_ns": (int, 1700000000000000000),
    },
    "light": {
        "sun_direction_C": (_vector(3), [-0.5, -0.5, -0.7]),
        "sun": (float, 1.0),
        "earth_direction_C": (_vector(3), [0.3, 1.0, -0.2]),
        "earthshine": (float, 0.4),
        "earth_half_angle_deg": (float, 64.0),
    },
    "background": {
        "kind": (str, "none"),
        "seed": (int, 5),
        "stars": (int, 3000),
        "altitude_km": (float, 520.0),
        "orbit_normal_C": (_vector(3), [1.0, 0.0, 0.0]),
        "orbit_rate_deg_s": (float, 0.063),
        "up_C": (_vector(3), [0.0, -1.0, 0.0]),
        "table_below_m": (float, 0.5),
    },
    "sensor": {
        "exposure": (float, 1.3),
        "exposure_s": (float, 0.0),
        "blur_samples": (int, 1),
        "full_well_e": (float, 20000.0),
        "read_noise_e": (float, 8.0),
        "gamma": (float, 2.2),
        "bits": (int, 8),
        "color": (str, "gray"),
    },
    "render": {"samples": (int, 16)},
}


def _is_number(x):
    return isinstance(x, (int, float)) and not isinstance(x, bool) and np.isfinite(x)


def _check_type(where, value, kind):
    """The value as the schema wants it, or SceneError."""

    def fail(wanted):
        raise SceneError(f"{where}: {wanted} expected, found {value!r}")

    if kind is float:
        return float(value) if _is_number(value) else fail("a number")
    if kind is int:
        return value if isinstance(value, int) and not isinstance(value, bool) else fail("a whole number")
    if kind is str:
        return value if isinstance(value, str) else fail("a text")
    if kind == "points":
        if not isinstance(value, list):
            fail("a list of [x, y, z]")
        return [_check_type(f"{where}[{i}]", v, _vector(3)) for i, v in enumerate(value)]
    if kind == "history":
        if not isinstance(value, list):
            fail("a list of [t_s, w, x, y, z]")
        return [_attitude_row(f"{where}[{i}]", v) for i, v in enumerate(value)]
    if kind == "inertia":
        return _inertia(where, value)
    if not (isinstance(value, list) and len(value) == kind[1] and all(_is_number(x) for x in value)):
        fail(f"{kind[1]} numbers")
    return value


def _attitude_row(where, value):
    """[t_s, w, x, y, z] with its quaternion brought to unit norm, or SceneError."""
    time_s, *q = _check_type(where, value, _vector(5))
    norm = float(np.linalg.norm(q))
    require(norm > 1e-6, f"{where}: the quaternion must not be zero")
    return [time_s, *(x / norm for x in q)]


def _inertia(where, value):
    """Inertia tensor (3, 3) as nested lists from a diagonal or a full tensor; physical, or SceneError."""
    if isinstance(value, list) and len(value) == 3 and all(_is_number(x) for x in value):
        tensor = np.diag(np.array(value, dtype=float))
    elif (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(r, list) and len(r) == 3 and all(_is_number(x) for x in r) for r in value)
    ):
        tensor = np.array(value, dtype=float)
    else:
        raise SceneError(f"{where}: 3 numbers or 3 rows of 3 numbers expected, found {value!r}")
    if np.abs(tensor - tensor.T).max() > 1e-9 * np.abs(tensor).max():
        raise SceneError(f"{where}: the tensor is not symmetric")
    principal = np.linalg.eigvalsh(tensor)
    if principal[0] <= 0:
        raise SceneError(f"{where}: principal moments must be positive, found {principal[0]:.4g} kg m^2")
    if principal[0] + principal[1] < principal[2] * (1 - 1e-9):
        raise SceneError(
            f"{where}: no body has the principal moments {principal[0]:.4g}, {principal[1]:.4g}, "
            f"{principal[2]:.4g}: the largest exceeds the sum of the others"
        )
    return tensor.tolist()


def _merge(base, overlay):
    out = copy.deepcopy(base)
    for key, value in overlay.items():
        out[key] = _merge(out.get(key, {}), value) if isinstance(value, dict) else value
    return out


def load(path, variant=None):
    """The checked scene (nested dict with every key present) of a TOML file; raises SceneError."""
    path = Path(path)
    try:
        raw = tomllib.loads(path.read_text())
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: {error}") from None
    variants = raw.pop("variants", {})
    if variant and variant not in variants:
        raise SceneError(f"{path}: no variant {variant!r}; there are: {', '.join(variants) or 'none'}")
    try:
        for name, overlay in variants.items():
            check_keys(overlay, f"variants.{name}.")
        scene = check(_merge(raw, variants[variant]) if variant else raw)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    if scene["target"]["kind"] == "file":
        model = path.parent / scene["target"]["path"]
        if not scene["target"]["path"] or not model.is_file():
            raise SceneError(f"{path}: target.path: no model file {model}")
        if model.suffix.lower() not in (".obj", ".stl", ".ply", ".gltf", ".glb"):
            raise SceneError(f"{path}: target.path: OBJ, STL, PLY or glTF expected, found {model.name}")
        scene["target"]["path"] = str(model)
        # Part of what decides the pixels, so that a changed model is another scene.
        scene["target"]["model_sha256"] = hashlib.sha256(model.read_bytes()).hexdigest()
    scene["variant"] = variant or "full"
    return scene


def check_keys(raw, prefix=""):
    """SceneError on a table or key that the schema does not have."""
    for key, value in raw.items():
        if key in SCHEMA[""]:
            continue
        if key not in SCHEMA:
            raise SceneError(f"unknown key {prefix}{key}")
        if not isinstance(value, dict):
            raise SceneError(f"{prefix}{key}: a table expected, found {value!r}")
        for inner in value:
            if inner not in SCHEMA[key]:
                raise SceneError(f"unknown key {prefix}{key}.{inner}")


def check(raw):
    """A raw table with defaults filled in and every value checked; raises SceneError."""
    check_keys(raw)
    scene = {}
    for table, keys in SCHEMA.items():
        given = raw if table == "" else raw.get(table, {})
        into = scene if table == "" else scene.setdefault(table, {})
        for key, (kind, default) in keys.items():
            where = f"{table}.{key}" if table else key
            if key in given:
                into[key] = _check_type(where, given[key], kind)
            elif default is None:
                raise SceneError(f"{where} is missing")
            else:
                into[key] = None if isinstance(default, str) and default == "" else copy.deepcopy(default)
    _check_values(scene)
    _check_camera(scene)
    return scene


def require(condition, message):
    """SceneError with the message unless the condition holds."""
    if not condition:
        raise SceneError(message)


def _check_values(scene):
    """Ranges and choices of what is shown."""

    target = scene["target"]
    require(scene["seed"] >= 0, "seed: must not be negative")
    require(target["detail_seed"] >= 0, "target.detail_seed: must not be negative")
    require(
        target["kind"] in TARGET_KINDS,
        f"target.kind: one of {', '.join(TARGET_KINDS)} expected, found {target['kind']!r}",
    )
    require(target["size_m"] > 0 and target["scale"] > 0, "target.size_m and target.scale: must be positive")
    require(64 <= target["texture_px"] <= 8192, "target.texture_px: 64 to 8192 expected")
    kind = scene["background"]["kind"]
    require(kind in BACKGROUNDS, f"background.kind: one of {', '.join(BACKGROUNDS)} expected, found {kind!r}")
    require(
        scene["background"]["stars"] >= 0 and scene["background"]["altitude_km"] > 100,
        "background: stars >= 0 and altitude_km > 100 expected",
    )
    require(scene["background"]["seed"] >= 0, "background.seed: must not be negative")
    translation = scene["motion"]["translation"]
    require(translation in ("constant", "hcw"), f"motion.translation: constant or hcw expected, found {translation!r}")
    require(scene["motion"]["mean_motion_rad_s"] > 0, "motion.mean_motion_rad_s: must be positive")
    for table, key in (
        ("motion", "q_CT0"),
        ("motion", "q_CH0"),
        ("light", "sun_direction_C"),
        ("light", "earth_direction_C"),
        ("background", "orbit_normal_C"),
        ("background", "up_C"),
    ):
        require(np.linalg.norm(scene[table][key]) > 1e-6, f"{table}.{key}: must not be zero")
    require(target["fiducial_radius_m"] > 0, "target.fiducial_radius_m: must be positive")


def _check_camera(scene):
    """Ranges and choices of what looks at it, and when."""
    camera, time, sensor = scene["camera"], scene["time"], scene["sensor"]
    width, height = camera["resolution"]
    require(
        isinstance(width, int) and isinstance(height, int) and 16 <= width <= 8192 and 16 <= height <= 8192,
        "camera.resolution: two whole numbers from 16 to 8192 expected",
    )
    require(camera["lens_mm"] > 0 and camera["sensor_width_mm"] > 0, "camera.lens_mm and sensor_width_mm: must be positive")
    if camera["intrinsics_px"] is not None:
        require(min(camera["intrinsics_px"][:2]) > 0, "camera.intrinsics_px: focal lengths must be positive")
    stamps = [row[0] for row in camera["attitude_history"]]
    require(all(b > a for a, b in zip(stamps, stamps[1:])), "camera.attitude_history: times must ascend")
    require(not (stamps and any(camera["w_C_deg_s"])), "camera: give attitude_history or w_C_deg_s, not both")
    require(
        time["frames"] >= 1 and time["period_s"] > 0 and time["start_s"] >= 0,
        "time: frames >= 1, period_s > 0, start_s >= 0 expected",
    )
    require(0 <= sensor["exposure_s"] <= time["period_s"], "sensor.exposure_s: from 0 to time.period_s expected")
    require(1 <= sensor["blur_samples"] <= 64, "sensor.blur_samples: 1 to 64 expected")
    require(sensor["bits"] in (8, 16), "sensor.bits: 8 or 16 expected")
    require(sensor["color"] in ("gray", "rgb"), "sensor.color: gray or rgb expected")
    require(not (sensor["bits"] == 16 and sensor["color"] == "rgb"), "sensor: 16 bit is for gray only")
    require(
        sensor["exposure"] > 0 and sensor["full_well_e"] > 0 and sensor["read_noise_e"] >= 0 and sensor["gamma"] >= 1,
        "sensor: exposure > 0, full_well_e > 0, read_noise_e >= 0, gamma >= 1 expected",
    )
    require(1 <= scene["render"]["samples"] <= 4096, "render.samples: 1 to 4096 expected")
