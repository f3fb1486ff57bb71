"""What a run found as messages of Foxglove's schemas, by foxglove-schemas-protobuf."""

import pathlib
from collections.abc import Iterator

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

from polhode_ground.common.sequence import Camera
from polhode_ground.common.tables import Motion, in_frame, target_frames
from polhode_ground.judge.shape import load_ply, property_of
from polhode_ground.plots.series import time_ns_of
from polhode_ground.reporting.gather import Material

CAMERA_FRAME = "C"  # as the pictures' frame_id
CLOUD_FIELDS = (
    ("x", "<f4", PackedElementField.FLOAT32),
    ("y", "<f4", PackedElementField.FLOAT32),
    ("z", "<f4", PackedElementField.FLOAT32),
    ("sigma", "<f4", PackedElementField.FLOAT32),
    ("views", "<i4", PackedElementField.INT32),
    ("added", "u1", PackedElementField.UINT8),
    ("red", "u1", PackedElementField.UINT8),
    ("green", "u1", PackedElementField.UINT8),
    ("blue", "u1", PackedElementField.UINT8),
    ("alpha", "u1", PackedElementField.UINT8),
)


def target_frame_name(kind: str) -> str:
    return f"T_{kind}"


def calibration(camera: Camera, time_ns: int) -> CameraCalibration:
    fu, fv, cu, cv = (float(value) for value in camera.intrinsics_px)
    message = CameraCalibration(
        frame_id=CAMERA_FRAME,
        width=camera.width_px,
        height=camera.height_px,
        distortion_model="plumb_bob",
        D=[*(float(value) for value in camera.distortion), 0.0],
        K=[fu, 0, cu, 0, fv, cv, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[fu, 0, cu, 0, 0, fv, cv, 0, 0, 0, 1, 0],
    )
    message.timestamp.FromNanoseconds(time_ns)
    return message


def transforms(kind: str, motion: Motion) -> Iterator[tuple[int, FrameTransform]]:
    """(time, T to C) of each row that has a pose."""
    for row in np.flatnonzero(motion.pose_valid):
        w, x, y, z = (float(value) for value in motion.q_CT[row])
        message = FrameTransform(parent_frame_id=CAMERA_FRAME, child_frame_id=target_frame_name(kind))
        message.translation.x, message.translation.y, message.translation.z = (float(value) for value in motion.p_CT[row])
        message.rotation.w, message.rotation.x, message.rotation.y, message.rotation.z = w, x, y, z
        message.timestamp.FromNanoseconds(int(motion.timestamp_ns[row]))
        yield int(motion.timestamp_ns[row]), message


def cloud(path: pathlib.Path, time_ns: int) -> PointCloud | None:
    """cloud.ply; None where it has no points."""
    mesh = load_ply(path) if path.exists() else None
    count = len(getattr(mesh, "vertices", ()))
    if count == 0:
        return None
    rows = np.zeros(count, dtype=[(name, kind) for name, kind, _ in CLOUD_FIELDS])
    rows["sigma"], rows["alpha"] = np.nan, 255
    for name, _, _ in CLOUD_FIELDS:
        values = property_of(mesh, name, count)
        if values is not None:
            rows[name] = values
    message = PointCloud(
        frame_id=target_frame_name("smoothed"),
        point_stride=rows.dtype.itemsize,
        data=rows.tobytes(),
        fields=[PackedElementField(name=name, offset=rows.dtype.fields[name][1], type=kind) for name, _, kind in CLOUD_FIELDS],
    )
    message.pose.orientation.w = 1.0
    message.timestamp.FromNanoseconds(time_ns)
    return message


def log(time_ns: int, text: str) -> Log:
    message = Log(level=Log.INFO, message=text, name="polhode")
    message.timestamp.FromNanoseconds(time_ns)
    return message


def messages_of(material: Material) -> Iterator[tuple[str, int, object]]:
    """(topic, time, message) of everything; poses of motion_smoothed.csv in its last frame T alone, where the cloud is."""
    start_ns = int(next(iter(material.run.motions.values())).timestamp_ns[0])
    if material.sequence is not None:
        yield "/camera/calibration", start_ns, calibration(material.sequence.camera, start_ns)
    for kind, motion in material.run.motions.items():
        last = in_frame(motion, target_frames(motion)[-1]) if kind == "smoothed" and motion.pose_valid.any() else motion
        for time_ns, message in transforms(kind, last):
            yield f"/target/{kind}", time_ns, message
    if (points := cloud(material.run.folder / "cloud.ply", start_ns)) is not None:
        yield "/target/cloud", start_ns, points
    for event in material.events:
        yield "/target/events", time_ns_of(event), log(time_ns_of(event), event.text)
