"""What a replay took for the target, drawn over its frames: needs a run made with --masks."""

import csv
import re
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.whole_file import MARK, beside

TARGET, OPEN = 128, 64
COLOUR_OF = {"target": "#3ddc4b", "background": "#ff5050", "unassigned": "#ffd040"}


@dataclass
class Mask:
    """One frame of masks.pgms: `target` and `open` [h,w] bool of the picture reduced by `decimation`."""

    frame: int
    used: bool
    behind: bool
    found: bool
    sharp: bool
    decimation: int
    target: np.ndarray
    open: np.ndarray

    def full(self, name: str, height_px: int, width_px: int) -> np.ndarray:
        """[height_px, width_px] bool of `target` or `open`, each reduced pixel repeated."""
        small = getattr(self, name)
        rows = np.minimum(np.arange(height_px) // self.decimation, small.shape[0] - 1)
        columns = np.minimum(np.arange(width_px) // self.decimation, small.shape[1] - 1)
        return small[rows][:, columns]


HEADER = re.compile(rb"P5\n# frame (\d+) used (\d) behind (\d) found (\d) sharp (\d) decimation (\d+)\n(\d+) (\d+)\n255\n")


def read_masks(path) -> list[Mask]:
    """All frames of a masks.pgms."""
    if not path.exists():
        raise BadInput(f"{path}: not there; replay with --masks")
    data, at, masks = path.read_bytes(), 0, []
    while at < len(data):
        match = HEADER.match(data, at)
        if match is None:
            raise BadInput(f"{path}: no picture at octet {at}")
        frame, used, behind, found, sharp, decimation, width, height = map(int, match.groups())
        at = match.end() + width * height
        if at > len(data):
            raise BadInput(f"{path}: ends within the picture of frame {frame}")
        pixels = np.frombuffer(data[match.end() : at], np.uint8).reshape(height, width)
        masks.append(
            Mask(frame, bool(used), bool(behind), bool(found), bool(sharp), decimation, (pixels & TARGET) > 0, (pixels & OPEN) > 0)
        )
    return masks


def read_tracks(path) -> dict[int, list[dict]]:
    """Rows of mask_tracks.csv by frame."""
    tracks = defaultdict(list)
    try:
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                tracks[int(row["frame"])].append(row)
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None
    return tracks


def read_observations(path) -> dict[int, list[dict]]:
    """Rows of observations.csv by frame: inliers are on the target, the others unassigned."""
    return read_tracks(path)


def draw_frame(axes, gray, mask: Mask, tracks: list[dict], observations: list[dict]) -> None:
    """The frame; what features may not be made of darkened, the target's outline, tracks by class."""
    height, width = gray.shape
    shade = np.where(mask.full("open", height, width), 1.0, 0.45)
    axes.imshow(gray * shade, cmap="gray", vmin=0, vmax=255)
    target = mask.full("target", height, width)
    if target.any() and not target.all():
        axes.contour(target, levels=[0.5], colors="#30b0ff", linewidths=1.0)
    for kind, colour in COLOUR_OF.items():
        own = [row for row in tracks if row["class"] == kind]
        axes.plot(
            [[float(r["from_u_px"]) for r in own], [float(r["u_px"]) for r in own]],
            [[float(r["from_v_px"]) for r in own], [float(r["v_px"]) for r in own]],
            color=colour,
            linewidth=0.8,
        )
        axes.plot([float(r["u_px"]) for r in own], [float(r["v_px"]) for r in own], ".", color=colour, markersize=3)
    for inlier, kind in (("1", "target"), ("0", "unassigned")):
        own = [row for row in observations if row["inlier"] == inlier]
        axes.plot(
            [float(r["u_px"]) for r in own], [float(r["v_px"]) for r in own], "+", color=COLOUR_OF[kind], markersize=4, markeredgewidth=0.6
        )
    state = "not used" if not mask.used else "before space" if not mask.behind else "target found" if mask.found else "target not found"
    axes.set_title(f"frame {mask.frame}: {state}{', at edges' if mask.sharp else ''}", fontsize=8)
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(height - 0.5, -0.5)
    axes.axis("off")


def draw(run_folder, masks: list[Mask], sequence, frames: list[int], out) -> list:
    """One PNG per frame asked for. @param masks  those of the run (read_masks)."""
    from matplotlib import pyplot

    masks = {mask.frame: mask for mask in masks}
    tracks, seen = read_tracks(run_folder / "mask_tracks.csv"), read_observations(run_folder / "observations.csv")
    paths = []
    for frame in frames:
        if frame not in masks:
            raise BadInput(f"{run_folder / 'masks.pgms'}: holds no frame {frame}")
        gray = sequence.read_gray(frame)
        figure, axes = pyplot.subplots(figsize=(gray.shape[1] / 100, gray.shape[0] / 100 + 0.3), dpi=100)
        draw_frame(axes, gray, masks[frame], tracks[frame], seen[frame])
        figure.set_layout_engine("tight", pad=0.2)
        paths.append(out / f"overlay_{frame:06d}.png")
        with beside(paths[-1]) as part:
            figure.savefig(part, metadata={"Software": MARK})
        pyplot.close(figure)
    return paths
