"""Writes image sequences for the tests of the program, good ones and spoiled ones."""

import pathlib

import numpy
from PIL import Image

WIDTH, HEIGHT = 160, 120

SENSOR = """\
sensor_type: camera
rate_hz: 10
resolution: [{width}, {height}]
camera_model: pinhole
intrinsics: [200.0, 200.0, 79.5, 59.5]
distortion_model: radial-tangential
distortion_coefficients: [0.0, 0.0, 0.0, 0.0]
"""


def write_image(path: pathlib.Path, pixels: numpy.ndarray) -> None:
    if path.suffix == ".pgm":
        depth = pixels.dtype.itemsize
        head = f"P5 {pixels.shape[1]} {pixels.shape[0]} {65535 if depth == 2 else 255}\n".encode()
        path.write_bytes(head + pixels.astype(">u2" if depth == 2 else "u1").tobytes())
    else:
        Image.fromarray(pixels).save(path, **({"quality": 95} if path.suffix == ".jpg" else {}))


class SequenceWriter:
    """A sequence folder under construction; its files may be overwritten before it is read."""

    def __init__(self, path: pathlib.Path, suffix: str = ".png", width: int = WIDTH, height: int = HEIGHT):
        self.path = path
        self.camera = path / "mav0" / "cam0"
        self.data = self.camera / "data"
        self.suffix = suffix
        self.data.mkdir(parents=True)
        self.rows: list[tuple[str, str]] = []
        self.sensor(SENSOR.format(width=width, height=height))

    def sensor(self, text: str) -> None:
        (self.camera / "sensor.yaml").write_text(text)

    def add(self, pixels: numpy.ndarray) -> pathlib.Path:
        stamp = 1_000_000_000 + 100_000_000 * len(self.rows)
        name = f"{stamp}{self.suffix}"
        write_image(self.data / name, pixels)
        self.rows.append((str(stamp), name))
        self.table()
        return self.data / name

    def table(self) -> None:
        lines = ["#timestamp [ns],filename", *(f"{stamp},{name}" for stamp, name in self.rows)]
        (self.camera / "data.csv").write_text("\n".join(lines) + "\n")


def uniform(value: int) -> numpy.ndarray:
    return numpy.full((HEIGHT, WIDTH), value, numpy.uint8)


def noise(seed: int) -> numpy.ndarray:
    return numpy.random.default_rng(seed).integers(0, 256, (HEIGHT, WIDTH), numpy.uint8)


def textured(seed: int = 1) -> numpy.ndarray:
    """A bright square with blobs of several sizes on black ground."""
    random = numpy.random.default_rng(seed)
    image = numpy.zeros((HEIGHT, WIDTH))
    v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    image[20:100, 40:120] = 110.0
    for _ in range(60):
        cu, cv, size = random.uniform(42, 118), random.uniform(22, 98), random.uniform(1.0, 3.5)
        image += random.uniform(-90, 120) * numpy.exp(-((u - cu) ** 2 + (v - cv) ** 2) / (2 * size**2)) * (image > 0)
    return numpy.clip(image, 0, 255).astype(numpy.uint8)
