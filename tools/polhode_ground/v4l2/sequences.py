"""Makes the small sequences that the virtual machine's jobs feed to the camera (the guest is some 70 times slower than its host).

usage: sequences.py FOLDER
  FOLDER/noise8, FOLDER/noise16   eight frames of 64x48 noise, 8 and 16 bits (the lower six bits zero, so that ten are enough)
  FOLDER/body                     a textured ball that turns by 4 deg a frame, 24 frames of 320x240
  FOLDER/small                    the same, 48 frames of 160x120
"""

import pathlib
import sys

import numpy
from PIL import Image
from scipy.spatial.transform import Rotation

SENSOR = """\
sensor_type: camera
rate_hz: 1
resolution: [{width}, {height}]
camera_model: pinhole
intrinsics: [{focal}, {focal}, {cu}, {cv}]
distortion_model: radial-tangential
distortion_coefficients: [0.0, 0.0, 0.0, 0.0]
"""
FIRST_NS = 1_000_000_000_000
STEP_NS = 1_000_000_000


def write(folder: pathlib.Path, images: list[numpy.ndarray], focal: float) -> None:
    camera = folder / "mav0" / "cam0"
    (camera / "data").mkdir(parents=True, exist_ok=True)
    height, width = images[0].shape
    (camera / "sensor.yaml").write_text(SENSOR.format(width=width, height=height, focal=focal, cu=(width - 1) / 2, cv=(height - 1) / 2))
    rows = ["#timestamp [ns],filename"]
    for i, image in enumerate(images):
        stamp = FIRST_NS + i * STEP_NS
        Image.fromarray(image).save(camera / "data" / f"{stamp}.png")
        rows.append(f"{stamp},{stamp}.png")
    (camera / "data.csv").write_text("\n".join(rows) + "\n")


class Ball:
    """Of radius 1, with patches of all sizes on it."""

    def __init__(self, seed: int, patches: int = 500):
        random = numpy.random.default_rng(seed)
        middles = random.normal(size=(patches, 3))
        self.middles = middles / numpy.linalg.norm(middles, axis=1, keepdims=True)
        self.edges = numpy.cos(0.04 + 0.12 * random.random(patches) * random.random(patches))
        self.heights = numpy.where(random.random(patches) < 0.5, -1.0, 1.0) * (30.0 + 40.0 * random.random(patches))

    def seen_from(self, R_CT: numpy.ndarray, p_CT: numpy.ndarray, width: int, height: int, focal: float) -> numpy.ndarray:
        v, u = numpy.mgrid[0:height, 0:width]
        rays = numpy.stack([(u - (width - 1) / 2) / focal, (v - (height - 1) / 2) / focal, numpy.ones(u.shape)], axis=-1)
        rays /= numpy.linalg.norm(rays, axis=-1, keepdims=True)
        along = rays @ p_CT
        under_root = along**2 - p_CT @ p_CT + 1.0
        hit = under_root > 0.0
        p_C = (along[hit] - numpy.sqrt(under_root[hit]))[:, None] * rays[hit]
        normals_T = (p_C - p_CT) @ R_CT  # rows: R_CT^T n
        inside = numpy.clip((normals_T @ self.middles.T - self.edges) / (1.0 - self.edges), 0.0, 1.0)
        levels = 120.0 + (inside**2 * (3.0 - 2.0 * inside)) @ self.heights
        image = numpy.zeros((height, width), numpy.uint8)
        image[hit] = numpy.clip(levels, 40.0, 250.0).astype(numpy.uint8)
        return image


def turn(angle_rad: float) -> numpy.ndarray:
    """Rotation [3,3] about a fixed, tilted axis."""
    axis = numpy.array([0.2, 1.0, 0.1])
    return Rotation.from_rotvec(angle_rad * axis / numpy.linalg.norm(axis)).as_matrix()


def body(frames: int = 24, width: int = 320) -> list[numpy.ndarray]:
    ball = Ball(3)
    return [ball.seen_from(turn(0.07 * i), numpy.array([0.05, -0.02, 8.0]), width, width * 3 // 4, width * 1.875) for i in range(frames)]


def main(folder: pathlib.Path) -> None:
    random = numpy.random.default_rng(8)
    write(folder / "noise8", [random.integers(0, 256, (48, 64)).astype(numpy.uint8) for _ in range(8)], 100.0)
    write(folder / "noise16", [(random.integers(0, 1024, (48, 64)) << 6).astype(numpy.uint16) for _ in range(8)], 100.0)
    write(folder / "body", body(), 600.0)
    write(folder / "small", body(48, 160), 300.0)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
