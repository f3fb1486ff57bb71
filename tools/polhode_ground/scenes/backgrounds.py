"""What is behind the target: nothing, stars, the Earth, or a laboratory. Linear radiance in camera pixels.

Every background answers radiance(motion, row) with linear RGB (H, W, 3) or None for black, and says in own_light
whether it brings its own lamps instead of sun and Earthshine.
"""

import numpy as np

from . import camera as camera_model
from . import noise
from .black_space import Empty
from .laboratory import Laboratory
from .rotations import quat_to_matrix

EARTH_RADIUS_KM = 6371.0
# Height over which the glow of the limb falls by e. Real air falls faster, but its bright layer starts higher up.
GLOW_SCALE_KM = 14.0


class Stars(Empty):
    """Points at rest in I, spread by the lens to about 0.7 px."""

    SPREAD_PX = 0.7

    def __init__(self, plan):
        settings = plan.scene["background"]
        rng = noise.generator(settings["seed"], 21)
        d = rng.standard_normal((settings["stars"], 3))
        self.direction_I = d / np.linalg.norm(d, axis=1, keepdims=True)
        # Counts grow about fourfold per 2.5 magnitudes, so the flux has a Pareto tail; the faintest are 2 % of white.
        self.flux = np.minimum(0.15 * rng.pareto(1.1, settings["stars"]) + 0.15, 12.0)
        self.camera = plan.camera

    def radiance(self, motion, row):
        """Linear RGB (H, W, 3) of the stars in view."""
        camera = self.camera
        out = np.zeros((camera.height, camera.width), dtype=np.float32)
        d_C = self.direction_I @ quat_to_matrix(motion.q_IC[row])
        for d, flux in zip(d_C, self.flux):
            # Points far outside fold back into the image under distortion: skip them by angle first.
            if d[2] < 0.3:
                continue
            ideal = d[:2] / d[2] * [camera.fu, camera.fv] + [camera.cu, camera.cv]
            if np.any(ideal < -0.3 * camera.width) or ideal[0] > 1.3 * camera.width or ideal[1] > 1.3 * camera.height:
                continue
            u, v = camera_model.project(camera, d)
            u0, v0 = int(round(u)), int(round(v))
            if not (4 <= u0 < camera.width - 4 and 4 <= v0 < camera.height - 4):
                continue
            yy, xx = np.mgrid[v0 - 3 : v0 + 4, u0 - 3 : u0 + 4]
            spot = np.exp(-((xx - u) ** 2 + (yy - v) ** 2) / (2 * self.SPREAD_PX**2))
            out[v0 - 3 : v0 + 4, u0 - 3 : u0 + 4] += flux * spot / (2 * np.pi * self.SPREAD_PX**2)
        return np.repeat(out[..., None], 3, axis=2)


class Earth(Empty):
    """The Earth from low orbit: ground at rest in I, the camera on a circular orbit around it.

    The direction to the Earth's centre turns with the orbit, so that limb, clouds and terminator move as they do for a
    camera that keeps its attitude. (The Earth's own turn is a sixteenth of that and is left out.)
    """

    def __init__(self, plan, stars):
        settings = plan.scene["background"]
        self.stars, self.camera = stars, plan.camera
        self.distance_km = EARTH_RADIUS_KM + settings["altitude_km"]
        self.plan = plan
        self.sun_I = plan.R_IC0 @ np.asarray(plan.scene["light"]["sun_direction_C"], dtype=float)
        self.sun_I /= np.linalg.norm(self.sun_I)
        u, v = np.meshgrid(np.arange(plan.camera.width, dtype=float), np.arange(plan.camera.height, dtype=float))
        xy = camera_model.pixel_rays(plan.camera, u, v)
        rays = np.concatenate([xy, np.ones_like(xy[..., :1])], axis=-1)
        self.ray_C = (rays / np.linalg.norm(rays, axis=-1, keepdims=True)).astype(np.float32)
        pole = plan.orbit_normal_I
        first = plan.earth_direction_I(0.0)
        first = first - np.dot(first, pole) * pole
        first /= np.linalg.norm(first)
        # Rows: axes of the map, with its pole along the orbit's normal, so that the track is its equator.
        self.R_EI = np.stack([first, np.cross(pole, first), pole]).astype(np.float32)
        rng = noise.generator(settings["seed"], 22)
        self.weather = noise.fractal((1024, 2048), rng, 3.1, 700)
        self.detail = noise.fractal((1024, 1024), rng, 2.3, 260)
        self.land = noise.fractal((512, 1024), rng, 3.4, 400)

    def radiance(self, motion, row):
        """Linear RGB (H, W, 3) of Earth, air and the stars beside it."""
        R_IC = quat_to_matrix(motion.q_IC[row])
        to_centre_I = self.plan.earth_direction_I(motion.time_s[row])
        along = self.ray_C @ (R_IC.T @ to_centre_I * self.distance_km).astype(np.float32)
        miss_km = np.sqrt(np.maximum(self.distance_km**2 - along**2, 0))
        hit = (along > 0) & (miss_km < EARTH_RADIUS_KM)
        out = self.stars.radiance(motion, row)
        depth = along - np.sqrt(np.maximum(EARTH_RADIUS_KM**2 - miss_km**2, 0))
        ray_I = self.ray_C @ R_IC.T.astype(np.float32)
        nearest = np.where(hit, depth, along)[..., None] * ray_I - (to_centre_I * self.distance_km).astype(np.float32)
        normal_I = nearest / np.linalg.norm(nearest, axis=-1, keepdims=True)
        lit = normal_I @ self.sun_I.astype(np.float32)
        day = noise.smoothstep(-0.08, 0.12, lit)
        ground = self._ground(normal_I[hit], np.clip(lit[hit], 0, 1))
        slant = np.clip(-np.sum(normal_I * ray_I, axis=-1), 0, 1)
        haze = (0.05 + 0.22 * np.exp(-slant / 0.10)) * day
        blue = np.array([0.45, 0.68, 1.0], dtype=np.float32)
        out[hit] = ground + haze[hit][:, None] * blue
        above_km = np.maximum(miss_km - EARTH_RADIUS_KM, 0)
        glow = np.where(~hit & (along > 0), 0.42 * np.exp(-above_km / GLOW_SCALE_KM) * day, 0)
        return (out + glow[..., None] * blue).astype(np.float32)

    def _ground(self, normal_I, lit):
        """Linear RGB (N, 3) of the surface at unit normals (N, 3) with cosine lit (N,) to the sun."""
        n = normal_I @ self.R_EI.T
        lon = np.arctan2(n[:, 1], n[:, 0]) / (2 * np.pi) % 1.0
        lat = np.arcsin(np.clip(n[:, 2], -1, 1)) / np.pi + 0.5
        weather = _wrapped(self.weather, lon, lat)
        # Two scales of a repeated tile, 1250 km and 330 km wide, give clouds down to a kilometre.
        fine = _wrapped(self.detail, lon * 32, lat * 16) + 0.5 * _wrapped(self.detail, lon * 121 + 0.3, lat * 60.5)
        cover = noise.smoothstep(-0.35, 2.0, weather + 0.6 * fine)[:, None]
        land = noise.smoothstep(0.25, 0.45, _wrapped(self.land, lon, lat) + 0.10 * fine)[:, None]
        sea = np.array([0.012, 0.035, 0.075], dtype=np.float32)
        soil = np.array([0.16, 0.125, 0.075], dtype=np.float32) * (1 + 0.25 * fine[:, None])
        base = sea + land * (soil - sea)
        cloud = 0.62 + 0.06 * fine[:, None]
        return (base + cover * (cloud - base)) * lit[:, None]


def _wrapped(image, s, t):
    """Bilinear samples (N,) of a periodic image at texture coordinates s, t."""
    h, w = image.shape
    x, y = (s % 1.0) * w, (t % 1.0) * h
    x0, y0 = x.astype(np.int32), y.astype(np.int32)
    fx, fy = x - x0, y - y0
    x0, y0 = x0 % w, y0 % h
    x1, y1 = (x0 + 1) % w, (y0 + 1) % h
    upper = image[y0, x0] * (1 - fx) + image[y0, x1] * fx
    return (upper * (1 - fy) + (image[y1, x0] * (1 - fx) + image[y1, x1] * fx) * fy).astype(np.float32)


def make(plan, resampler, blender, scratch_path, vertices_T):
    """The background that the scene asks for; the target's vertices_T (N, 3) tell where it can throw its shadow."""
    kind = plan.scene["background"]["kind"]
    if kind == "none":
        return Empty()
    if kind == "laboratory":
        return Laboratory(plan, resampler, blender, scratch_path, vertices_T)
    stars = Stars(plan)
    return stars if kind == "stars" else Earth(plan, stars)
