"""Takes a lens' distortion out of pictures."""

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.lens import Lens

# Nothing wider than 120 deg is a useful pinhole (the replay doubts it): a pixel at its edge sees a quarter of what one in its middle does.
EDGE_MAX = np.tan(np.radians(59.0))
ZOOMS = 4.0 * 0.98 ** np.arange(320)  # down to 0.006 of the lens' own focal length
BORDER_POINTS = 48  # of each edge


class Undistorter:
    """The result is a pinhole of the same size, looking where the picture's middle looks, as wide as leaves no edge empty."""

    def __init__(self, lens: Lens, where: str):
        self._given, self._where = lens, where
        self._focal_px = self._focal_on_axis()
        self._middle = self._ray_of_middle()
        self.zoom = self._widest()
        fu, fv = self.zoom * self._focal_px
        half = np.array([lens.width_px - 1, lens.height_px - 1]) / 2
        self.lens = Lens(lens.width_px, lens.height_px, (fu, fv, *(half - self._middle * (fu, fv))))
        v, u = np.mgrid[0 : lens.height_px, 0 : lens.width_px]
        places = lens.project(self._rays(np.column_stack([u.ravel(), v.ravel()]), self.zoom))
        self._maps = [places[:, i].reshape(u.shape).astype(np.float32) for i in (0, 1)]

    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        import cv2

        return cv2.remap(pixels, *self._maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

    @property
    def words(self) -> str:
        fu, fv, cu, cv = self.lens.intrinsics_px
        fields = [
            np.degrees(np.arctan((side - 0.5 - centre) / focal) + np.arctan((centre + 0.5) / focal))
            for side, centre, focal in ((self.lens.width_px, cu, fu), (self.lens.height_px, cv, fv))
        ]
        x, y = self._given.project(self._rays(self._border(), self.zoom)).T
        kept = abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) / 2 / (self.lens.width_px * self.lens.height_px)
        return (
            f"the lens' model is {self._given.words}: the pictures are undistorted to a pinhole of {fields[0]:.4g} deg x {fields[1]:.4g} deg, "
            f"which leaves out {100 * max(0.0, 1 - kept):.2g} % at their edges"
        )

    def _focal_on_axis(self) -> np.ndarray:
        """fu and fv of the pinhole that is like the lens on its axis."""
        step = 1e-4
        left, right, up, down = self._given.project(np.array([[-step, 0, 1], [step, 0, 1], [0, -step, 1], [0, step, 1]]))
        focal_px = np.array([right[0] - left[0], down[1] - up[1]]) / (2 * step)
        if not (focal_px > 0).all():
            self._refuse("it does not project what lies on its axis")
        return focal_px

    def _ray_of_middle(self) -> np.ndarray:
        """x / z and y / z near the picture's middle: on the line from the axis to where a pinhole would see it."""
        middle_px = np.array([self._given.width_px - 1, self._given.height_px - 1]) / 2
        candidates = np.linspace(0, 4, 401)[:, None] * (middle_px - self._given.intrinsics_px[2:]) / self._focal_px
        seen = self._given.project(np.column_stack([candidates, np.ones(len(candidates))]))
        away_px = np.linalg.norm(seen - middle_px, axis=1)
        if not np.isfinite(away_px).any():
            self._refuse("it does not project the picture's middle")
        return candidates[np.nanargmin(away_px)]

    def _border(self) -> np.ndarray:
        """Pixels around the picture."""
        right, bottom = self._given.width_px - 1, self._given.height_px - 1
        along = np.linspace(0, 1, BORDER_POINTS, endpoint=False)[:, None]
        corners = np.array([[0, 0], [right, 0], [right, bottom], [0, bottom]], float)
        return np.concatenate([corner + along * (after - corner) for corner, after in zip(corners, np.roll(corners, -1, axis=0))])

    def _rays(self, pixels: np.ndarray, zoom: float) -> np.ndarray:
        half = np.array([self._given.width_px - 1, self._given.height_px - 1]) / 2
        return np.column_stack([(pixels - half) / (zoom * self._focal_px) + self._middle, np.ones(len(pixels))])

    def _widest(self) -> float:
        coarse = self._good(ZOOMS)
        if coarse == 0:
            self._refuse("no part of the pictures is seen as the coefficients say")
        fine = np.linspace(ZOOMS[coarse - 1], ZOOMS[min(coarse, len(ZOOMS) - 1)], 50)
        return float(fine[self._good(fine) - 1])

    def _good(self, zooms: np.ndarray) -> int:
        """Of falling zooms, how many come before the first that shows what the pictures do not hold, or hold twice."""
        border = self._border()
        rays = np.concatenate([self._rays(border, zoom) for zoom in zooms])
        places = self._given.project(rays).reshape(len(zooms), -1, 2)
        size = np.array([self._given.width_px, self._given.height_px])
        inside = ((places >= -0.5) & (places <= size - 0.5)).all(axis=(1, 2))
        flat = (np.abs(rays[:, :2]).reshape(len(zooms), -1) <= EDGE_MAX).all(axis=1)
        # Where a model folds back, farther rays come nearer: these places have been seen already.
        away = np.linalg.norm(places - self._given.project(np.array([[*self._middle, 1.0]])), axis=2)
        grows = np.append(True, (np.diff(away, axis=0) > 0).all(axis=1))
        return int(np.cumprod(inside & flat & grows).sum())

    def _refuse(self, why: str) -> None:
        numbers = ", ".join(f"{value:g}" for value in (*self._given.intrinsics_px, *self._given.coefficients))
        raise BadInput(f"{self._where}: the lens ({self._given.words}: {numbers}) can't be taken out of the pictures: {why}")
