"""What of a picture is the target, by the truth: the mesh of a sequence drawn with its true poses."""

from typing import Any

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import Sequence
from polhode_ground.common.tables import read_motion
from polhode_ground.judge.align import rotations

# Pixels are drawn this much finer and counted as target when half of them is.
FINER = 3


class Silhouettes:
    """Masks [H,W] bool of a sequence with model.ply and truth.csv."""

    def __init__(self, sequence: Sequence):
        import trimesh

        if not sequence.model_path.exists():
            raise BadInput(f"{sequence.model_path}: no mesh to draw silhouettes from")
        mesh: Any = trimesh.load(sequence.model_path, process=False)
        self.vertices_T, self.faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        self.camera, self.truth = sequence.camera, read_motion(sequence.truth_path)
        self.row_of = {int(stamp): row for row, stamp in enumerate(self.truth.timestamp_ns)}

    def of(self, timestamp_ns: int) -> np.ndarray:
        """Every triangle filled: a closed body's silhouette needs no depth."""
        from PIL import Image, ImageDraw

        row = self.row_of[int(timestamp_ns)]
        p_C = rotations(self.truth.q_CT[row : row + 1])[0].apply(self.vertices_T) + self.truth.p_CT[row]
        # Corner of the finer grid's pixel (0, 0) is at -0.5, as that of the picture.
        finer_px = (self.camera.project(p_C) + 0.5) * FINER - 0.5
        picture = Image.new("1", (self.camera.width_px * FINER, self.camera.height_px * FINER))
        draw = ImageDraw.Draw(picture)
        for triangle in finer_px[self.faces]:
            if np.isfinite(triangle).all():
                draw.polygon([tuple(corner) for corner in triangle], fill=1)
        finer = np.asarray(picture).reshape(self.camera.height_px, FINER, self.camera.width_px, FINER)
        return np.asarray(finer.mean(axis=(1, 3)) >= 0.5)


def overlap(mask: np.ndarray, truth: np.ndarray) -> float:
    """Intersection over union of two masks."""
    union = (mask | truth).sum()
    return float((mask & truth).sum() / union) if union else 1.0
