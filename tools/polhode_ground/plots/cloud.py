"""The cloud in three views, alone and with the camera's path around it."""

import numpy as np

from polhode_ground.plots import series, style
from polhode_ground.plots.style import plt

VIEWS = ((0, 1, 2), (0, 2, 1), (1, 2, 0))  # horizontal, vertical, depth
AXES = "xyz"
POINTS_MAX = 20000


def _path_and_cloud(run, truth):
    """(cloud [N,3], camera path [M,3], seconds [M], description of the frame) or None."""
    found = series.cloud_and_path(run, truth)
    if found is None:
        return None
    points, camera, rows, kind, aligned, unit = found
    where = f"the {'estimate' if aligned is None else 'truth'}'s body axes [{unit}]"
    return points[:: max(1, len(points) // POINTS_MAX)], camera, run.motions[kind].seconds[rows], where


def _bulk(points: np.ndarray) -> np.ndarray:
    """Corners [2,3] of the box around the points but their farthest strays, which would shrink the body to a dot."""
    return np.percentile(points, [0.5, 99.5], axis=0)


def _limits(axis, points: np.ndarray, i: int, j: int, margin: float = 0.08) -> None:
    """Equal axes around all of the points, the same size in each view."""
    low, high = points.min(axis=0), points.max(axis=0)
    half = (0.5 + margin) * (high - low).max()
    centre = (low + high) / 2
    axis.set_xlim(centre[i] - half, centre[i] + half)
    axis.set_ylim(centre[j] - half, centre[j] + half)
    axis.set_aspect("equal")


def draw(run, truth, folder, prefix: str = "") -> list:
    """cloud.png: upper row the cloud (brighter is nearer to the viewer), lower row with the camera's path."""
    found = _path_and_cloud(run, truth)
    if found is None or len(found[0]) == 0:
        return []
    points, camera, seconds, where = found
    time, label = style.time_axis(seconds)
    range_mu = np.linalg.norm(camera, axis=1)
    near = camera[range_mu <= 3 * np.median(range_mu)]  # a wild pose does not set the scale
    body = _bulk(points)
    figure, axes = plt.subplots(2, 3, figsize=(12, 7.6))
    for column, (i, j, depth) in enumerate(VIEWS):
        sign = -1 if (i, j) == (0, 2) else 1  # x-z is looked at along +y, the others against their third axis
        order = np.argsort(sign * points[:, depth])
        upper, lower = axes[:, column]
        upper.scatter(
            points[order, i],
            points[order, j],
            s=3,
            c=sign * points[order, depth],
            cmap="cividis",
            lw=0,
            vmin=min(sign * body[:, depth]),
            vmax=max(sign * body[:, depth]),
        )
        _limits(upper, body, i, j)
        lower.plot(camera[:, i], camera[:, j], color="#bbbbbb", lw=0.7, zorder=1)
        dots = lower.scatter(camera[:, i], camera[:, j], s=7, c=time, cmap="viridis", lw=0, zorder=2)
        lower.scatter(points[:, i], points[:, j], s=0.6, color="#444444", lw=0, zorder=3)
        _limits(lower, np.vstack([body, near]), i, j, margin=0.06)
        for axis in (upper, lower):
            axis.set_xlabel(f"{AXES[i]}")
            axis.set_ylabel(f"{AXES[j]}")
    figure.colorbar(dots, ax=axes[1, :], label=f"camera, {label}", shrink=0.85)
    figure.suptitle(f"Cloud of {len(points)} points (above) and the camera's path around it (below), in {where}", fontsize=11)
    return [style.save(figure, folder, f"{prefix}cloud.png")]
