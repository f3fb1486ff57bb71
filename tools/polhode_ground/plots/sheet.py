"""Contact sheet: frames with tracks and reprojected landmarks drawn in."""

from dataclasses import dataclass

import numpy as np
from matplotlib.lines import Line2D

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import numbers, read_cells
from polhode_ground.judge import align
from polhode_ground.judge.shape import read_cloud
from polhode_ground.plots import style
from polhode_ground.plots.style import plt

COLUMNS, ROWS = 4, 3
TRAIL_FRAMES = 4  # a track's way through this many earlier frames
OBSERVATION_COLUMNS = ("timestamp_ns", "landmark", "u_px", "v_px", "predicted_u_px", "predicted_v_px", "inlier")
# A track without a landmark's number carries none: it has no trail.
TRACK = "#ffd92f"


@dataclass
class Observations:
    """All rows of observations.csv; landmark is NaN for a track that is no landmark."""

    timestamp_ns: np.ndarray
    landmark: np.ndarray
    seen_px: np.ndarray  # [N,2]
    predicted_px: np.ndarray  # [N,2], NaN where unknown
    inlier: np.ndarray  # [N] bool

    def of(self, timestamp_ns: int) -> "Observations":
        rows = np.flatnonzero(self.timestamp_ns == timestamp_ns)
        return Observations(self.timestamp_ns[rows], self.landmark[rows], self.seen_px[rows], self.predicted_px[rows], self.inlier[rows])


def read_observations(path) -> Observations | None:
    """The file, or None where the run has none."""
    if not path.exists():
        return None
    header, rows = read_cells(path)
    missing = [name for name in OBSERVATION_COLUMNS if name not in header]
    if missing:
        raise BadInput(f"{path}: column {missing[0]} is missing")
    cells = dict(zip(header, zip(*rows))) if rows else dict.fromkeys(header, ())
    value = {name: numbers(path, name, cells[name]) for name in OBSERVATION_COLUMNS[1:]}
    try:
        timestamp_ns = np.array([int(cell) for cell in cells["timestamp_ns"]], dtype=np.int64)
    except ValueError:
        raise BadInput(f"{path}: timestamp_ns holds something that is not a whole number") from None
    return Observations(
        timestamp_ns,
        value["landmark"],
        np.stack([value["u_px"], value["v_px"]], axis=1),
        np.stack([value["predicted_u_px"], value["predicted_v_px"]], axis=1),
        value["inlier"] > 0,
    )


def _choose(run, sequence, observations) -> list[int]:
    """Indices of the frames to show: spread over the run, the first and the last included."""
    count = min(COLUMNS * ROWS, len(sequence.timestamp_ns))
    return sorted({int(i) for i in np.linspace(0, len(sequence.timestamp_ns) - 1, count).round()})


def _window(points_px: np.ndarray, width_px: int, height_px: int) -> tuple[float, float, float, float]:
    """Part of the frame around the points, in the frame's own aspect, so that a far target is not a dot."""
    points_px = points_px[np.isfinite(points_px).all(axis=1)]
    if len(points_px) < 8:
        return -0.5, width_px - 0.5, height_px - 0.5, -0.5
    low, high = np.percentile(points_px, [1, 99], axis=0)
    aspect = width_px / height_px
    width = min(max((high - low)[0] * 1.35, (high - low)[1] * 1.35 * aspect, 0.12 * width_px), width_px)
    height = width / aspect
    centre = np.clip((low + high) / 2, [width / 2, height / 2], [width_px - width / 2, height_px - height / 2])
    return (centre[0] - width / 2 - 0.5, centre[0] + width / 2 - 0.5, centre[1] + height / 2 - 0.5, centre[1] - height / 2 - 0.5)


def _trails(axis, now: Observations, before: list[Observations]) -> None:
    """Lines from where each inlier was seen in the frames before to where it is seen now."""
    segments = []
    end = {int(number): point for number, point in zip(now.landmark[now.inlier], now.seen_px[now.inlier]) if np.isfinite(number)}
    for earlier in before:
        places = {int(number): point for number, point in zip(earlier.landmark, earlier.seen_px) if np.isfinite(number)}
        segments += [(places[number], end[number]) for number in places if number in end]
        end = {number: places.get(number, point) for number, point in end.items()}
    if segments:
        from matplotlib.collections import LineCollection

        axis.add_collection(LineCollection(segments, colors=style.CAUSAL, linewidths=0.6, alpha=0.8))


def _draw_observations(axis, now: Observations) -> np.ndarray:
    """Circles where seen, crosses where the landmark reprojects; returns the pixels that frame the target."""
    if len(now.landmark) == 0:
        axis.annotate("nothing observed", (0.5, -0.03), xycoords="axes fraction", fontsize=7, ha="center", va="top")
        return now.seen_px
    landmark = np.isfinite(now.landmark)
    good, bad, loose = landmark & now.inlier, landmark & ~now.inlier, ~landmark
    for rows, colour in ((good, style.GOOD), (bad, style.BAD)):
        axis.plot(*now.seen_px[rows].T, "o", ms=2.2, mfc="none", mec=colour, mew=0.45)
    axis.plot(*now.seen_px[loose].T, ".", ms=0.9, color=TRACK)
    axis.plot(*now.predicted_px[landmark].T, "+", ms=2.0, mew=0.4, color=style.TRUTH)
    residual = np.linalg.norm(now.seen_px - now.predicted_px, axis=1)[good]
    residual = residual[np.isfinite(residual)]
    text = f"{good.sum()} inliers" + (f", median {np.median(residual):.2f} px" if len(residual) else "")
    axis.annotate(text, (0.5, -0.03), xycoords="axes fraction", fontsize=7, ha="center", va="top")
    return now.seen_px[landmark] if landmark.any() else now.seen_px


def _draw_cloud(axis, run, sequence, timestamp_ns: int, points_E: np.ndarray) -> np.ndarray:
    """Without observations: the cloud projected by the pose of the frame."""
    motion = run.motions.get("smoothed") or next(iter(run.motions.values()))
    rows = np.flatnonzero((motion.timestamp_ns == timestamp_ns) & motion.pose_valid)
    if len(rows) == 0 or len(points_E) == 0:
        return np.empty((0, 2))
    p_C = align.rotations(motion.q_CT[rows])[0].apply(points_E) + motion.p_CT[rows[0]]
    pixels = sequence.camera.project(p_C)
    axis.plot(*pixels.T, ".", ms=1.2, color=style.TRUTH, alpha=0.6)
    return pixels


def _title(run, index: int, timestamp_ns: int) -> str:
    motion = next(iter(run.motions.values()))
    rows = np.flatnonzero(motion.timestamp_ns == timestamp_ns)
    mode = motion.mode[rows[0]] if len(rows) and motion.mode else ""
    return f"frame {index} {mode}".strip()


def _legend(figure, observed: bool) -> None:
    marks = [
        ("o", style.GOOD, "landmark seen, inlier"),
        ("o", style.BAD, "landmark seen, rejected"),
        ("+", style.TRUTH, "landmark reprojected"),
        (".", TRACK, "track, no landmark yet"),
    ]
    handles = [Line2D([], [], marker=m, color=c, ls="", mfc="none" if m == "o" else c, label=t) for m, c, t in marks]
    handles.append(Line2D([], [], color=style.CAUSAL, label=f"way through the last {TRAIL_FRAMES} frames"))
    if not observed:
        handles = [Line2D([], [], marker=".", ls="", color=style.TRUTH, label="cloud reprojected by the frame's pose")]
    figure.legend(handles=handles, loc="outside upper center", ncols=5, fontsize=8)


def draw(run, sequence, folder, prefix: str = "") -> list:
    """contact_sheet.png; frames that can't be read are said so in their place."""
    observations = read_observations(run.folder / "observations.csv")
    cloud = next((run.folder / name for name in ("cloud.ply", "cloud_raw.ply") if (run.folder / name).exists()), None)
    points_E = read_cloud(cloud)[:1500] if observations is None and cloud else np.empty((0, 3))
    camera = sequence.camera
    figure, axes = plt.subplots(ROWS, COLUMNS, figsize=(16, 16 * ROWS * camera.height_px / camera.width_px / COLUMNS + 1.5))
    for axis in np.ravel(axes):
        axis.set_axis_off()
    for axis, index in zip(np.ravel(axes), _choose(run, sequence, observations)):
        timestamp_ns = int(sequence.timestamp_ns[index])
        axis.set_title(_title(run, index, timestamp_ns), fontsize=8, pad=2)
        try:
            axis.imshow(sequence.read_gray(index), cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        except BadInput:
            axis.text(0.5, 0.5, "frame can't be read", transform=axis.transAxes, ha="center")
            continue
        if observations is None:
            pixels = _draw_cloud(axis, run, sequence, timestamp_ns, points_E)
        else:
            before = [observations.of(int(t)) for t in sequence.timestamp_ns[max(0, index - TRAIL_FRAMES) : index][::-1]]
            now = observations.of(timestamp_ns)
            _trails(axis, now, before)
            pixels = _draw_observations(axis, now)
        left, right, bottom, top = _window(pixels, camera.width_px, camera.height_px)
        axis.set_xlim(left, right)
        axis.set_ylim(bottom, top)
    _legend(figure, observations is not None)
    return [style.save(figure, folder, f"{prefix}contact_sheet.png")]
