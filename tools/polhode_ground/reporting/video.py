"""The sequence as a video with what was found drawn in: surface, outline, axes, tracks, mode and time."""

import csv
import pathlib
from collections.abc import Iterator

import cv2
import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.tables import in_frame, target_frames
from polhode_ground.common.whole_file import MARK, beside
from polhode_ground.judge import align
from polhode_ground.plots.series import cloud_and_path
from polhode_ground.reporting.frames import overlaid
from polhode_ground.reporting.gather import Material

RATE_HZ = 15  # of the video: a sequence of one frame a second would be watched for hours
TRAIL_FRAMES = 4
NET_FACES_MAX = 300
SURFACE_OPACITY = 0.45
SURFACE_BGR, SEEN_BGR, REJECTED_BGR, TEXT_BGR = (150, 120, 60), (90, 220, 90), (60, 120, 255), (235, 235, 235)


def observations_by_time(path: pathlib.Path) -> Iterator[tuple[int, dict[int, tuple[float, float, bool]]]]:
    """(timestamp, {landmark: (u, v, inlier)}) frame by frame; tracks without a landmark are left out. Nothing without the file."""
    if not path.exists():
        return
    with open(path, newline="") as stream:
        now, places = None, {}
        for row in csv.DictReader(stream):
            time_ns = int(row["timestamp_ns"])
            if now is not None and time_ns != now:
                yield now, places
                places = {}
            now = time_ns
            if row["landmark"]:
                places[int(float(row["landmark"]))] = (float(row["u_px"]), float(row["v_px"]), row["inlier"] == "1")
        if now is not None:
            yield now, places


def surface_of(folder: pathlib.Path):
    """(vertices [N,3], faces [M,3]) of surface.ply, None where there is none."""
    import trimesh

    path = folder / "surface.ply"
    mesh = trimesh.load(path, process=False) if path.exists() else None
    return (np.asarray(mesh.vertices), np.asarray(mesh.faces)) if mesh is not None and hasattr(mesh, "faces") and len(mesh.faces) else None


def draw_surface(picture: np.ndarray, camera, R_CT, p_CT: np.ndarray, surface) -> None:
    """What is turned to the camera: edges as a thin net, or a translucent shaded surface where a net would hide the picture."""
    vertices, faces = surface
    p_C = R_CT.apply(vertices) + p_CT
    pixels = camera.project(p_C)
    corners = p_C[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = (np.einsum("ij,ij->i", normals, corners[:, 0]) < 0) & np.isfinite(pixels[faces]).all(axis=(1, 2))
    net = [pixels[face].round().clip(-30000, 30000).astype(np.int32) for face in faces[facing]]
    if len(faces) <= NET_FACES_MAX:
        cv2.polylines(picture, net, True, SURFACE_BGR, 1, cv2.LINE_AA)
        return
    towards = corners[facing].mean(axis=1)
    shade = np.abs(np.einsum("ij,ij->i", normals[facing], towards)) / np.maximum(
        np.linalg.norm(normals[facing], axis=1) * np.linalg.norm(towards, axis=1), 1e-300
    )
    layer, covered = np.zeros_like(picture), np.zeros(picture.shape[:2], np.uint8)
    for at in np.argsort(-np.linalg.norm(towards, axis=1)):  # the far ones first
        cv2.fillConvexPoly(layer, net[at], [float(shade[at] * 1.5 * value) for value in SURFACE_BGR])
        cv2.fillConvexPoly(covered, net[at], 255)
    picture[covered > 0] = cv2.addWeighted(picture, 1 - SURFACE_OPACITY, layer, SURFACE_OPACITY, 0)[covered > 0]


def draw_tracks(picture: np.ndarray, history: list[dict[int, tuple[float, float, bool]]]) -> None:
    """@param history  of the last frames, this one last."""
    for landmark, (u, v, inlier) in history[-1].items():
        path = [one[landmark][:2] for one in history if landmark in one]
        colour = SEEN_BGR if inlier else REJECTED_BGR
        if inlier and len(path) > 1:
            cv2.polylines(picture, [np.array(path).round().astype(np.int32)], False, colour, 1, cv2.LINE_AA)
        cv2.circle(picture, (round(u), round(v)), 2, colour, 1, cv2.LINE_AA)


def _caption(picture: np.ndarray, index: int, seconds: float, mode: str) -> None:
    size = max(0.4, picture.shape[1] / 1600)
    cv2.putText(
        picture,
        f"frame {index}  {seconds:.2f} s  {mode}",
        (8, picture.shape[0] - 10),
        cv2.FONT_HERSHEY_SIMPLEX,
        size,
        TEXT_BGR,
        1,
        cv2.LINE_AA,
    )


def pictures(material: Material) -> Iterator[np.ndarray]:
    """Frame by frame in BGR; one that can't be read is black."""
    sequence, run = material.sequence, material.run
    found, surface = cloud_and_path(run, None), surface_of(run.folder)
    points = found[0] if found is not None else None
    smoothed, causal = run.motions.get("smoothed"), run.motions.get("causal") or next(iter(run.motions.values()))
    last = in_frame(smoothed, target_frames(smoothed)[-1]) if smoothed is not None and smoothed.pose_valid.any() else None
    rows = {int(time): row for row, time in enumerate(causal.timestamp_ns)}
    poses = {int(last.timestamp_ns[row]): row for row in np.flatnonzero(last.pose_valid)} if last is not None else {}
    observed = observations_by_time(run.folder / "observations.csv")
    seen, history = next(observed, None), []
    for index, time_ns in enumerate(sequence.timestamp_ns.tolist()):
        try:
            picture, _ = overlaid(material, index, points, material.shape.get("shape") or {})
        except BadInput:
            picture = np.zeros((sequence.camera.height_px, sequence.camera.width_px, 3), np.uint8)
        if surface is not None and time_ns in poses:
            row = poses[time_ns]
            draw_surface(picture, sequence.camera, align.rotations(last.q_CT[[row]])[0], last.p_CT[row], surface)
        while seen is not None and seen[0] < time_ns:
            seen = next(observed, None)
        history = [*history, seen[1] if seen is not None and seen[0] == time_ns else {}][-TRAIL_FRAMES:]
        draw_tracks(picture, history)
        mode = causal.mode[rows[time_ns]] if time_ns in rows and causal.mode else ""
        _caption(picture, index, (time_ns - int(sequence.timestamp_ns[0])) * 1e-9, mode)
        yield picture


def write_video(material: Material, path: pathlib.Path) -> int:
    """@return frames written."""
    import av

    if material.sequence is None:
        raise BadInput(f"--video {path}: {material.remarks[0] if material.remarks else 'the sequence is needed: give --sequence'}")
    count = 0
    try:
        with beside(path) as part, av.open(str(part), "w", format="mp4") as container:
            container.metadata["comment"] = MARK
            stream = container.add_stream("libx264", rate=RATE_HZ, options={"crf": "20"})
            stream.width, stream.height = (
                size - size % 2 for size in (material.sequence.camera.width_px, material.sequence.camera.height_px)
            )
            stream.pix_fmt = "yuv420p"  # what every player shows; it needs even sizes
            for picture in pictures(material):
                frame = np.ascontiguousarray(picture[: stream.height, : stream.width])
                container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="bgr24")))
                count += 1
            container.mux(stream.encode(None))
    except (OSError, av.FFmpegError) as problem:
        raise BadInput(f"--video {path}: {problem.strerror or problem}") from None
    return count
