"""What light, lens and encoder do to pictures: the geometry stays, so the truth does.

Pixel values are taken for radiance to the power 1/2.2, as cameras encode it, where light is added or taken away.
"""

import cv2
import numpy as np

from polhode_ground.common.fault_log import LogEntry
from polhode_ground.transforms.footage import Footage, noisy

GAMMA = 2.2


def _each(footage: Footage, kind: str, detail: str, change) -> Footage:
    """change(gray, frame) on every frame; the log has one line."""
    shots = [shot.redrawn(lambda gray, frame=frame: change(gray, frame)) for frame, shot in enumerate(footage.shots)]
    return footage.changed(shots, [LogEntry(0, footage.shots[0].timestamp_ns, kind, f"all frames: {detail}")])


def _linear(gray: np.ndarray) -> np.ndarray:
    return (gray.astype(np.float32) / 255) ** GAMMA


def _encoded(radiance: np.ndarray) -> np.ndarray:
    return np.rint(255 * np.clip(radiance, 0, 1) ** (1 / GAMMA)).astype(np.uint8)


def jpeg(footage: Footage, options: dict, seed: int) -> Footage:
    """Encoded as JPEG and decoded again."""

    def change(gray, _frame):
        return cv2.imdecode(cv2.imencode(".jpg", gray, [cv2.IMWRITE_JPEG_QUALITY, options["quality"]])[1], cv2.IMREAD_GRAYSCALE)

    return _each(footage, "jpeg", f"quality {options['quality']}", change)


def noise(footage: Footage, options: dict, seed: int) -> Footage:
    """Normal noise of every pixel, independent."""

    def change(gray, frame):
        return noisy(gray, options["sigma_gray"], np.random.default_rng([seed, 1, frame]))

    return _each(footage, "noise", f"sigma {options['sigma_gray']} gray levels", change)


def gamma(footage: Footage, options: dict, seed: int) -> Footage:
    """Another response curve: gray levels to a power."""
    table = np.rint(255 * (np.arange(256) / 255) ** options["exponent"]).astype(np.uint8)
    return _each(footage, "gamma", f"exponent {options['exponent']}", lambda gray, _frame: table[gray])


def eclipse(footage: Footage, options: dict, seed: int) -> Footage:
    """The sun goes and comes back: light falls to `darkness` of itself between two times, with ramps beside them."""
    light = options["darkness"] ** footage.ramps(options)
    shots, log = list(footage.shots), []
    for frame in np.flatnonzero(light < 1):

        def change(gray, factor=light[frame], frame=frame):
            rng = np.random.default_rng([seed, 1, int(frame)])
            return _encoded(factor * _linear(gray) + rng.normal(0, 2e-4, gray.shape).astype(np.float32))

        shots[frame] = shots[frame].redrawn(change)
        log.append(LogEntry(int(frame), shots[frame].timestamp_ns, "eclipse", f"{light[frame]:.4f} of the light"))
    return footage.changed(shots, log)


def _flare_picture(shape, strength: float, part: float) -> np.ndarray:
    """A veil from one corner and ghosts on the line through the centre, moving with the sun. Radiance [H,W]."""
    height, width = shape
    v, u = np.mgrid[0:height, 0:width].astype(np.float32)
    sun = np.array([0.1 + 0.25 * part, -0.1]) * [width, height]
    centre = np.array([width, height]) / 2
    veil = np.exp(-np.hypot(u - sun[0], v - sun[1]) / (0.45 * width))
    light = 0.5 * strength * veil
    for place, radius in ((0.6, 0.03), (1.1, 0.05), (1.5, 0.09), (1.9, 0.04)):
        ghost = sun + place * (centre - sun)
        light += 0.25 * strength * (np.hypot(u - ghost[0], v - ghost[1]) < radius * width)
    return cv2.GaussianBlur(light, (0, 0), 1.5)


def flare(footage: Footage, options: dict, seed: int) -> Footage:
    """Stray light of a sun beside the picture."""
    count = len(footage.shots)
    return _each(
        footage,
        "flare",
        f"strength {options['strength']}",
        lambda gray, frame: _encoded(_linear(gray) + _flare_picture(gray.shape, options["strength"], frame / max(count - 1, 1))),
    )


def dirt(footage: Footage, options: dict, seed: int) -> Footage:
    """Spots on the lens, out of focus: they take light away and stay where they are."""
    shape = (footage.camera.height_px, footage.camera.width_px)
    rng = np.random.default_rng([seed, 1])
    passed = np.ones(shape, dtype=np.float32)
    for _ in range(options["spots"]):
        centre = (int(rng.integers(shape[1])), int(rng.integers(shape[0])))
        cv2.circle(passed, centre, max(1, int(options["size_part"] * shape[1] * rng.uniform(0.5, 1.5))), 1 - options["loss"], -1)
    passed = cv2.GaussianBlur(passed, (0, 0), max(0.8, 0.25 * options["size_part"] * shape[1]))
    return _each(footage, "dirt", f"{options['spots']} spots", lambda gray, _frame: _encoded(passed * _linear(gray)))


def caption(footage: Footage, options: dict, seed: int) -> Footage:
    """Text burnt into the picture: a title at rest above, a counter that runs below."""

    def change(gray, frame):
        picture, height = gray.copy(), gray.shape[0]
        scale = options["height_part"] * height / 22
        for text, row in (("CAM 1  POLHODE", options["height_part"] * height), (f"T+{frame:05d}", height - 4)):
            cv2.putText(picture, text, (6, int(row)), cv2.FONT_HERSHEY_SIMPLEX, scale, 230, max(1, round(scale)), cv2.LINE_AA)
        return picture

    return _each(footage, "caption", f"{options['height_part']} of the height", change)


def own_structure(footage: Footage, options: dict, seed: int) -> Footage:
    """A part of the servicer at rest in the picture: a lit, patterned arm from the lower left."""
    height, width = footage.camera.height_px, footage.camera.width_px
    rng, reach = np.random.default_rng([seed, 1]), options["reach_part"]
    outline = np.array(
        [[0, height * (1 - reach)], [reach * width * 0.9, height - 0.25 * reach * height], [reach * width, height], [0, height]]
    ).astype(np.int32)
    cover = cv2.fillPoly(np.zeros((height, width), dtype=np.uint8), [outline], 255) > 0
    pattern = cv2.resize(
        rng.uniform(60, 220, (height // 8, width // 8)).astype(np.float32), (width, height), interpolation=cv2.INTER_NEAREST
    )

    def change(gray, frame):
        grain = np.random.default_rng([seed, 2, frame]).normal(0, 1.5, gray.shape)
        return np.where(cover, np.clip(pattern + grain, 0, 255), gray).astype(np.uint8)

    return _each(footage, "own_structure", f"{reach} of the width", change)
