"""A Rerun recording of a run: camera, pictures, cloud, surface, axes, rates, modes and events on the sequence's own time.

The root is the camera's frame C. `target/causal` and `target/smoothed` are the frames T of motion.csv and
motion_smoothed.csv, as transforms that take T to C. The cloud is in the last T of motion_smoothed.csv alone. Rates are
drawn in one frame T, that of the smoothed poses: lines of the same motion lie on each other.
"""

import pathlib

import cv2
import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import read_octets, viewable
from polhode_ground.common.tables import Motion, in_frame, target_frames
from polhode_ground.common.whole_file import MARK, beside
from polhode_ground.judge.run import Run
from polhode_ground.judge.shape import load_ply, property_of
from polhode_ground.plots.series import common_rates, time_ns_of
from polhode_ground.reporting.gather import Material

AXIS_RGB = ((214, 39, 40), (44, 160, 44), (31, 119, 180))
PALE_RGB = ((240, 160, 160), (160, 215, 160), (155, 195, 230))  # of the same axes, as known at each frame
CLOUD_POINTS = 1.2  # radius on the screen; as a negative number Rerun takes it for that. The picture shows between them.


def _at(recording, time_ns: int) -> None:
    recording.set_time("time", timestamp=np.datetime64(time_ns, "ns"))


def _log_camera(rr, recording, sequence) -> None:
    fu, fv, cu, cv = sequence.camera.intrinsics_px
    # Rerun's pixels begin at their corner, ours are named by their centre. It knows no distortion.
    recording.log(
        "camera",
        rr.Pinhole(
            focal_length=[fu, fv],
            principal_point=[cu + 0.5, cv + 0.5],
            width=sequence.camera.width_px,
            height=sequence.camera.height_px,
            camera_xyz=rr.ViewCoordinates.RDF,
        ),
        static=True,
    )


def _log_pictures(rr, recording, sequence) -> None:
    for index, time_ns in enumerate(sequence.timestamp_ns.tolist()):
        _at(recording, time_ns)
        try:
            octets = read_octets(sequence.frame_path(index))
            kind = None if sequence.mosaic else viewable(octets)
            if kind is None:
                octets = cv2.imencode(".png", sequence.read_gray(index))[1].tobytes()
        except BadInput:
            continue  # a frame that can't be read: Rerun goes on showing the one before
        recording.log("camera/image", rr.EncodedImage(contents=octets, media_type=f"image/{kind or 'png'}"))


def _log_axes(rr, recording, entity: str, length: float) -> None:
    recording.log(f"{entity}/axes", rr.Arrows3D(vectors=length * np.eye(3), colors=AXIS_RGB, labels=["x", "y", "z"]))


def _log_body(rr, recording, entity: str, folder: pathlib.Path) -> None:
    """Cloud and surface, by themselves in T."""
    cloud = load_ply(folder / "cloud.ply") if (folder / "cloud.ply").exists() else None
    points = np.asarray(getattr(cloud, "vertices", np.empty((0, 3))))
    if len(points):
        added = property_of(cloud, "added", len(points))
        colours = np.where((np.zeros(len(points)) if added is None else added)[:, None] > 0, (240, 140, 40), (200, 200, 200))
        recording.log(f"{entity}/cloud", rr.Points3D(points, colors=colours.astype(np.uint8), radii=-CLOUD_POINTS))
    surface = load_ply(folder / "surface.ply") if (folder / "surface.ply").exists() else None
    if len(getattr(surface, "faces", ())):
        added = property_of(surface, "added", len(surface.vertices))
        colours = np.where(
            (np.zeros(len(surface.vertices)) if added is None else added)[:, None] > 0, (240, 140, 40, 90), (120, 150, 190, 90)
        )
        recording.log(
            f"{entity}/surface",
            rr.Mesh3D(vertex_positions=surface.vertices, triangle_indices=surface.faces, vertex_colors=colours.astype(np.uint8)),
        )


def _log_poses(rr, recording, kind: str, motion: Motion, length: float, folder: pathlib.Path | None) -> int:
    """@return poses. What hangs on a pose is logged anew after each gap: without a pose it is taken away."""
    entity, shown = f"target/{kind}", False
    for row, time_ns in enumerate(motion.timestamp_ns.tolist()):
        _at(recording, time_ns)
        if not motion.pose_valid[row]:
            if shown:
                recording.log(entity, rr.Clear(recursive=True))
            shown = False
            continue
        w, x, y, z = motion.q_CT[row]
        recording.log(entity, rr.Transform3D(translation=motion.p_CT[row], quaternion=rr.Quaternion(xyzw=[x, y, z, w])))
        if not shown:
            _log_axes(rr, recording, entity, length)
            if folder is not None:
                _log_body(rr, recording, entity, folder)
        shown = True
    return int(motion.pose_valid.sum())


def _log_rates(rr, recording, kind: str, run: Run) -> None:
    motion, w = run.motions[kind], np.degrees(common_rates(run, kind, None))
    colours = PALE_RGB if kind == "causal" else AXIS_RGB
    recording.log(f"rates/{kind}", rr.SeriesLines(names=[f"w_{axis} {kind} [deg/s]" for axis in "xyz"], colors=colours), static=True)
    recording.log(f"rates/{kind}_sigma", rr.SeriesLines(names=f"sigma {kind} [deg/s]", colors=(190, 190, 90)), static=True)
    for row in np.flatnonzero(motion.rate_valid):
        _at(recording, int(motion.timestamp_ns[row]))
        recording.log(f"rates/{kind}", rr.Scalars(w[row]))
        sigma = motion.columns["sigma_rate_rad_s"][row]
        if np.isfinite(sigma):
            recording.log(f"rates/{kind}_sigma", rr.Scalars(np.degrees(sigma)))


def _log_words(rr, recording, material: Material) -> None:
    motion = material.run.motions.get("causal")
    before = ""
    for time_ns, mode in zip(motion.timestamp_ns.tolist(), motion.mode) if motion is not None else ():
        if mode != before:
            _at(recording, time_ns)
            recording.log("mode", rr.TextLog(mode, level="INFO"))
        before = mode
    for event in material.events:
        _at(recording, time_ns_of(event))
        recording.log("events", rr.TextLog(event.text, level="INFO"))


def _blueprint():
    """The surface is in the scene alone: over the picture it would hide what the camera saw."""
    import rerun.blueprint as rrb

    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(origin="/", name="target before the camera"),
                rrb.Spatial2DView(origin="camera", contents=["/**", "- /target/smoothed/surface"], name="picture"),
            ),
            rrb.Vertical(rrb.TimeSeriesView(origin="rates", name="angular velocity"), rrb.TextLogView(origin="/", name="modes and events")),
        )
    )


def write_rrd(material: Material, path: pathlib.Path) -> int:
    """@return poses written, those of every motion file."""
    try:
        import rerun as rr
    except ImportError:
        raise BadInput(f"--rrd {path}: rerun-sdk is not installed; run tools/setup.sh extras") from None
    if not path.parent.is_dir():
        raise BadInput(f"--rrd {path}: {path.parent}: no such folder")
    with beside(path) as part:
        return _write(rr, material, path, part)


def _write(rr, material: Material, path: pathlib.Path, part: pathlib.Path) -> int:
    recording = rr.RecordingStream("polhode", recording_id=material.run.name)
    recording.set_log_time_enabled(False)
    recording.set_log_tick_enabled(False)
    try:
        recording.save(part, default_blueprint=_blueprint())
    except (OSError, RuntimeError) as problem:
        raise BadInput(f"--rrd {path}: {problem}") from None
    recording.log("made_by", rr.TextDocument(MARK), static=True)
    recording.log("/", rr.ViewCoordinates.RDF, static=True)
    if material.sequence is not None:
        _log_camera(rr, recording, material.sequence)
        _log_pictures(rr, recording, material.sequence)
    dimensions = (material.shape.get("shape") or {}).get("dimensions")
    length = 0.7 * max(dimensions) if dimensions else 1.0
    poses = 0
    for kind, motion in material.run.motions.items():
        last = in_frame(motion, target_frames(motion)[-1]) if kind == "smoothed" and motion.pose_valid.any() else motion
        poses += _log_poses(rr, recording, kind, last, length, material.run.folder if kind == "smoothed" else None)
        _log_rates(rr, recording, kind, material.run)
    _log_words(rr, recording, material)
    recording.disconnect()
    return poses
