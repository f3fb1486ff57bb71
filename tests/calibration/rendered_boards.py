"""Pictures of a board through a camera whose intrinsics and distortion are known exactly."""

import cv2
import numpy

WIDTH, HEIGHT = 640, 480
INTRINSICS = numpy.array([700.0, 705.0, 322.7, 236.1])  # fu, fv, cu, cv
DISTORTION = numpy.array([-0.21, 0.09, 0.0012, -0.0008])  # k1, k2, p1, p2


def rays_of(u: numpy.ndarray, v: numpy.ndarray) -> numpy.ndarray:
    """Directions (x, y, 1) of pixels: the distortion inverted by fixed-point iteration, which converges for so little of it."""
    k1, k2, p1, p2 = DISTORTION
    xd, yd = (u - INTRINSICS[2]) / INTRINSICS[0], (v - INTRINSICS[3]) / INTRINSICS[1]
    x, y = xd.copy(), yd.copy()
    for _ in range(40):
        r2 = x * x + y * y
        radial = 1.0 + k1 * r2 + k2 * r2 * r2
        x = (xd - 2 * p1 * x * y - p2 * (r2 + 2 * x * x)) / radial
        y = (yd - p1 * (r2 + 2 * y * y) - 2 * p2 * x * y) / radial
    return numpy.stack([x, y, numpy.ones_like(x)], axis=-1)


def chessboard(columns: int, rows: int):
    """Level at a place on the board, in squares; white outside."""

    def level(a: numpy.ndarray, b: numpy.ndarray) -> numpy.ndarray:
        on = (a >= 0) & (a < columns) & (b >= 0) & (b < rows)
        return numpy.where(on & ((numpy.floor(a) + numpy.floor(b)) % 2 == 0), 30.0, 225.0)

    return level


def printed(board, columns: int, rows: int, per_square: int = 60):
    """The same from a picture of the board."""
    image = board.charuco().generateImage((columns * per_square, rows * per_square)).astype(float)

    def level(a: numpy.ndarray, b: numpy.ndarray) -> numpy.ndarray:
        on = (a >= 0) & (a < columns) & (b >= 0) & (b < rows)
        i = numpy.clip((b * per_square).astype(int), 0, image.shape[0] - 1)
        j = numpy.clip((a * per_square).astype(int), 0, image.shape[1] - 1)
        return numpy.where(on, 30.0 + 195.0 / 255.0 * image[i, j], 225.0)

    return level


def seen(level, square_m: float, R: numpy.ndarray, t: numpy.ndarray, random: numpy.random.Generator, samples: int = 2):
    """The board at pose p_C = R p_board + t, each pixel averaged over samples x samples points, with a little noise."""
    total = numpy.zeros((HEIGHT, WIDTH))
    for i in range(samples):
        for j in range(samples):
            v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
            rays = rays_of(u + (i + 0.5) / samples - 0.5, v + (j + 0.5) / samples - 0.5)
            depth = (R[:, 2] @ t) / (rays @ R[:, 2])
            board = (depth[..., None] * rays - t) @ R
            total += numpy.where(depth > 0, level(board[..., 0] / square_m, board[..., 1] / square_m), 225.0)
    image = total / samples**2 + random.normal(0.0, 1.5, total.shape)
    return numpy.clip(numpy.round(image), 0, 255).astype(numpy.uint8)


def poses(columns: int, rows: int, square_m: float, count: int, random: numpy.random.Generator):
    """Tilted by up to 40 deg, in all parts of the picture."""
    centre = numpy.array([columns, rows, 0.0]) * square_m / 2
    for n in range(count):
        tilt = numpy.deg2rad(numpy.array([35.0 * numpy.cos(2.4 * n), 35.0 * numpy.sin(2.4 * n), random.uniform(-20, 20)]))
        R, _ = cv2.Rodrigues(tilt)
        distance = random.uniform(0.95, 1.2) * columns * square_m * INTRINSICS[0] / 420.0
        aside = numpy.array([((n % 3) - 1) * 0.09, ((n // 3 % 3) - 1) * 0.05, 0.0]) * distance
        yield R, numpy.array([0.0, 0.0, distance]) + aside - R @ centre
