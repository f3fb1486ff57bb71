"""A body of boxes with texture, and what a camera sees of it: a ray a pixel, whatever its pose."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from polhode_ground.common.sequence import Camera

# About as many as a face has pixels: one ray a pixel is enough.
TEXELS = 112
PSF_PX = 0.7
NEAR_M = 1e-3
AMBIENT = 0.15


@dataclass(frozen=True)
class Box:
    """centre_T, half_T: [3] in T, m. texture: [6, TEXELS, TEXELS] reflectance of the faces -x, +x, -y, +y, -z, +z."""

    centre_T: np.ndarray
    half_T: np.ndarray
    texture: np.ndarray


def _texture(rng: np.random.Generator) -> np.ndarray:
    """Reflectance [TEXELS, TEXELS]: spots and lines of several sizes on an uneven ground."""
    coarse = rng.uniform(0.25, 0.75, (7, 7)).astype(np.float32)
    face = cv2.resize(coarse, (TEXELS, TEXELS), interpolation=cv2.INTER_CUBIC)
    for _ in range(int(rng.integers(15, 70))):
        centre = tuple(int(x) for x in rng.integers(0, TEXELS, 2))
        radius, gray = int(rng.integers(2, 9)), float(rng.uniform(0.05, 1.0))
        if rng.random() < 0.5:
            cv2.circle(face, centre, radius, gray, -1, cv2.LINE_AA)
        else:
            cv2.rectangle(face, centre, (centre[0] + 2 * radius, centre[1] + radius), gray, -1)
    return np.clip(face, 0.0, 1.0)


def random_body(rng: np.random.Generator) -> list[Box]:
    """One to three boxes; their common size is about a metre."""
    boxes = []
    for number in range(int(rng.integers(1, 4))):
        half_T = rng.uniform(0.12, 0.5, 3) if number == 0 else rng.uniform(0.02, 0.35, 3)
        centre_T = np.zeros(3) if number == 0 else rng.uniform(-0.5, 0.5, 3)
        boxes.append(Box(centre_T, half_T, np.stack([_texture(rng) for _ in range(6)])))
    return boxes


def _hit(box: Box, origin_T: np.ndarray, rays_T: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(distance [N], face [N]) at which rays [3,N] from origin_T enter the box, inf where they don't; from within they leave it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (((box.centre_T + sign * box.half_T - origin_T)[:, None] / rays_T).astype(np.float32) for sign in (-1.0, 1.0))
    enters, leaves = np.fmin(one, other), np.fmax(one, other)
    axis_in, axis_out = np.argmax(enters, axis=0), np.argmin(leaves, axis=0)
    near, far = enters.max(axis=0), leaves.min(axis=0)
    within = near < NEAR_M
    axis, distance = np.where(within, axis_out, axis_in), np.where(within, far, near)
    upper = (rays_T[axis, np.arange(len(axis))] < 0) != within
    return np.where((near <= far) & (far > NEAR_M), distance, np.inf), 2 * axis + upper


def _pixels_of(box: Box, camera: Camera, R_CT: Rotation, p_CT: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns that hold the box's picture, by the sphere about it; all of them where the camera is close."""
    fu, fv, cu, cv = camera.intrinsics_px
    centre_C, radius = R_CT.apply(box.centre_T) + p_CT, float(np.linalg.norm(box.half_T))
    whole = slice(0, camera.height_px), slice(0, camera.width_px)
    if centre_C[2] < -radius:
        return slice(0, 0), slice(0, 0)
    if centre_C[2] < 2 * radius:
        return whole
    near = centre_C[2] - radius
    ends = [
        np.clip(
            [
                min((x - radius) / near, (x - radius) / (near + 2 * radius)) * f + c,
                max((x + radius) / near, (x + radius) / (near + 2 * radius)) * f + c + 1,
            ],
            0,
            size,
        ).astype(int)
        for x, f, c, size in ((centre_C[1], fv, cv, camera.height_px), (centre_C[0], fu, cu, camera.width_px))
    ]
    return slice(*ends[0]), slice(*ends[1])


def picture(body: list[Box], camera: Camera, q_CT: np.ndarray, p_CT: np.ndarray, light_C: np.ndarray, background: np.ndarray) -> np.ndarray:
    """Radiance [H,W] in 0 .. 1: boxes under a light from light_C, in front of the background [H,W]. The camera has no distortion."""
    R_CT = Rotation.from_quat(q_CT, scalar_first=True)
    R_TC = R_CT.inv()
    fu, fv, cu, cv = camera.intrinsics_px
    origin_T, light_T = R_TC.apply(-p_CT), R_TC.apply(light_C)
    radiance, nearest = background.astype(np.float32), np.full(background.shape, np.inf, np.float32)
    for box in body:
        rows, columns = _pixels_of(box, camera, R_CT, p_CT)
        x, y = np.meshgrid((np.arange(columns.start, columns.stop) - cu) / fu, (np.arange(rows.start, rows.stop) - cv) / fv)
        if x.size == 0:
            continue
        rays_T = (R_TC.as_matrix() @ np.stack([x.ravel(), y.ravel(), np.ones(x.size)])).astype(np.float32)
        distance, face = _hit(box, origin_T, rays_T)
        near = nearest[rows, columns].ravel()
        seen = np.flatnonzero(distance < near)
        near[seen] = distance[seen]
        nearest[rows, columns] = near.reshape(x.shape)
        lit = radiance[rows, columns].ravel()
        lit[seen] = _radiance(box, origin_T, rays_T[:, seen], distance[seen], face[seen], light_T)
        radiance[rows, columns] = lit.reshape(x.shape)
    return cv2.GaussianBlur(radiance, (0, 0), PSF_PX)


def _radiance(box: Box, origin_T, rays_T, distance, face, light_T) -> np.ndarray:
    """Of the points that rays [3,N] meet at `distance` on `face`."""
    axis, column = face // 2, np.arange(len(face))
    place = ((origin_T - box.centre_T)[:, None] + distance * rays_T) / box.half_T[:, None]
    texel = ((np.stack([place[(axis + 1) % 3, column], place[(axis + 2) % 3, column]]) + 1) / 2 * (TEXELS - 1)).clip(0, TEXELS - 1)
    low = np.minimum(texel.astype(int), TEXELS - 2)
    (a, b), (i, j) = texel - low, low
    reflectance = (1 - a) * ((1 - b) * box.texture[face, i, j] + b * box.texture[face, i, j + 1]) + a * (
        (1 - b) * box.texture[face, i + 1, j] + b * box.texture[face, i + 1, j + 1]
    )
    return reflectance * (AMBIENT + (1 - AMBIENT) * np.maximum(0.0, np.where(face % 2 == 1, 1.0, -1.0) * light_T[axis]))
