"""A ROS 2 bag of the poses, by rosbags, stored as MCAP: poses with covariances, TF, angular velocities and the cloud.

C is an optical frame of ROS as it is (REP 103: z forward, x right, y down). ROS takes lengths for metres. What is in map units is in a
tree of frames of its own, whose names say so.
"""

import pathlib
import shutil

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from polhode_ground.common.errors import BadInput
from polhode_ground.common.whole_file import fresh_beside
from polhode_ground.exporting.poses import Poses, counted
from polhode_ground.exporting.times import NS
from polhode_ground.judge.shape import load_ply, property_of

BAG_MARK = ".polhode-export"
BAG_VERSION = 9
CAMERA_FRAME = "camera_optical_frame"
POSE, TF, VECTOR, CLOUD = (
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "tf2_msgs/msg/TFMessage",
    "geometry_msgs/msg/Vector3Stamped",
    "sensor_msgs/msg/PointCloud2",
)
# (name, numpy's type, code of PointField); PointCloud2's viewers take colours from "rgb".
CLOUD_FIELDS = (
    ("x", "<f4", 7),
    ("y", "<f4", 7),
    ("z", "<f4", 7),
    ("rgb", "<u4", 7),
    ("sigma", "<f4", 7),
    ("views", "<i4", 5),
    ("added", "u1", 2),
)
# ROS has the position before the rotation. Both are perturbations in the axes of the parent frame, as ours are.
POSITION_FIRST = [3, 4, 5, 0, 1, 2]


def frames_of(poses: Poses, row: int) -> tuple[str, str]:
    """Names of C and T of a pose."""
    kind = "_smoothed" if poses.kind == "smoothed" else ""
    unit = "" if poses.metres[row] else f"_map_units_{poses.unit[row]}"
    # The smoothed poses have a map unit of their own, too.
    return f"{CAMERA_FRAME}{kind if unit else ''}{unit}", f"target_{poses.target[row]}{kind}{unit}"


class Messages:
    """Makes messages of ROS' own definitions."""

    def __init__(self):
        self.store = get_typestore(Stores.ROS2_HUMBLE)

    def make(self, kind: str, **fields):
        return self.store.types[kind](**fields)

    def header(self, time_ns: int, frame: str):
        stamp = self.make("builtin_interfaces/msg/Time", sec=time_ns // NS, nanosec=time_ns % NS)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def vector(self, values):
        x, y, z = map(float, values)
        return self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def quaternion(self, q):
        w, x, y, z = map(float, q)
        return self.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def of_pose(self, poses: Poses, row: int):
        """(end of the topic or the whole of it, type, message) of one pose."""
        camera, target = frames_of(poses, row)
        header = self.header(int(poses.time_ns[row]), camera)
        x, y, z = map(float, poses.p_CT[row])
        pose = self.make(
            "geometry_msgs/msg/Pose",
            position=self.make("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=self.quaternion(poses.q_CT[row]),
        )
        covariance = np.nan_to_num(poses.cov_pose[row][np.ix_(POSITION_FIRST, POSITION_FIRST)].reshape(-1))  # ROS: zeros are "unknown"
        yield (
            "pose",
            POSE,
            self.make(POSE, header=header, pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance)),
        )
        transform = self.make("geometry_msgs/msg/Transform", translation=self.vector(poses.p_CT[row]), rotation=pose.orientation)
        stamped = self.make("geometry_msgs/msg/TransformStamped", header=header, child_frame_id=target, transform=transform)
        yield "/tf", TF, self.make(TF, transforms=[stamped])
        if np.isfinite(poses.w_T[row]).all():
            yield (
                "angular_velocity",
                VECTOR,
                self.make(VECTOR, header=self.header(int(poses.time_ns[row]), target), vector=self.vector(poses.w_T[row])),
            )

    def cloud(self, rows: np.ndarray, time_ns: int, frame: str):
        fields = [
            self.make("sensor_msgs/msg/PointField", name=name, offset=rows.dtype.fields[name][1], datatype=code, count=1)
            for name, _, code in CLOUD_FIELDS
        ]
        return self.make(
            CLOUD,
            header=self.header(time_ns, frame),
            height=1,
            width=len(rows),
            fields=fields,
            is_bigendian=False,
            point_step=rows.dtype.itemsize,
            row_step=rows.nbytes,
            data=np.frombuffer(rows.tobytes(), np.uint8),
            is_dense=True,
        )


def cloud_rows(path: pathlib.Path, metres_per_unit: float) -> np.ndarray | None:
    """Points as PointCloud2 has them; None where there are none."""
    mesh = load_ply(path) if path.exists() else None
    count = len(getattr(mesh, "vertices", ()))
    if count == 0:
        return None
    rows = np.zeros(count, dtype=[(name, kind) for name, kind, _ in CLOUD_FIELDS])
    rows["sigma"] = np.nan
    found = {name: property_of(mesh, name, count) for name in ("x", "y", "z", "sigma", "views", "added", "red", "green", "blue")}
    for name in ("x", "y", "z", "sigma", "views", "added"):
        if found[name] is not None:
            rows[name] = found[name] * (metres_per_unit if name in ("x", "y", "z", "sigma") else 1)
    if found["red"] is not None:
        red, green, blue = (found[name].astype(np.uint32) for name in ("red", "green", "blue"))
        rows["rgb"] = red << 16 | green << 8 | blue
    return rows


def check_bag(out: pathlib.Path) -> None:
    """@raise BadInput where something that we did not write is in the way."""
    if not out.exists():
        return
    ours = {BAG_MARK, "metadata.yaml"}
    if not out.is_dir():
        raise BadInput(f"{out}: is there already and is no folder; a ROS 2 bag is one; move it away or give another name")
    others = sorted(file.name for file in out.iterdir() if file.name not in ours and file.suffix != ".mcap")
    if others or (any(out.iterdir()) and not (out / BAG_MARK).exists()):
        raise BadInput(
            f"{out}: holds files that this command did not write ({', '.join(others) or 'no ' + BAG_MARK}); allowed is a new, an empty or an earlier call's folder"
        )


def write_rosbag2(motions: list[Poses], run: pathlib.Path, out: pathlib.Path, metres_per_unit: float | None) -> tuple[str, list[str]]:
    """@return what is in it, and what was left out."""
    check_bag(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    part = fresh_beside(out)
    try:
        counts, remarks = _fill(part, motions, run, metres_per_unit)
        (part / BAG_MARK).touch()
        for file in part.glob(f"{part.name}*.mcap"):
            _rename(part, file, file.name.replace(part.name, out.name))
        if out.exists():
            shutil.rmtree(out)  # check_bag() found nothing of others in it
        part.rename(out)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return ", ".join(counts), remarks


def _rename(folder: pathlib.Path, file: pathlib.Path, name: str) -> None:
    """The bag was written under a name that nobody has, which its metadata repeat."""
    metadata = folder / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace(file.name, name))
    file.rename(folder / name)


def _fill(part: pathlib.Path, motions: list[Poses], run: pathlib.Path, metres_per_unit: float | None) -> tuple[list[str], list[str]]:
    messages, connections, counts, remarks = Messages(), {}, [], []
    with Writer(part, version=BAG_VERSION, storage_plugin=StoragePlugin.MCAP) as writer:

        def add(topic: str, kind: str, time_ns: int, message) -> None:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=messages.store)
            writer.write(connections[topic], time_ns, messages.store.serialize_cdr(message, kind))

        for time_ns, moving, row in sorted(
            ((int(time_ns), poses, row) for poses in motions for row, time_ns in enumerate(poses.time_ns)), key=lambda one: one[0]
        ):
            for topic, kind, message in messages.of_pose(moving, row):
                add(topic if topic.startswith("/") else f"/target/{moving.kind}/{topic}", kind, time_ns, message)
        counts += [f"{counted(len(poses), 'pose')} of {poses.source}" for poses in motions]
        for poses in motions:
            remarks += _unit_remarks(poses)
        points = cloud_rows(run / "cloud.ply", metres_per_unit or 1.0)
        last = next((poses for poses in motions if poses.kind == "smoothed"), None)
        if points is not None and last is not None:
            time_ns = int(last.time_ns[last.target == last.last_target][0])
            add("/target/cloud", CLOUD, time_ns, messages.cloud(points, time_ns, frames_of(last, len(last) - 1)[1]))
            counts.append(counted(len(points), "point"))
        elif points is not None:
            remarks.append("cloud.ply is left out: it is in the T of motion_smoothed.csv, which is not there")
    return counts, remarks


def _unit_remarks(poses: Poses) -> list[str]:
    remarks = [f"{poses.source}: {poses.covariances_from}"]
    if not poses.metres.all():
        count, frame = int(np.sum(~poses.metres)), frames_of(poses, int(np.flatnonzero(~poses.metres)[0]))[0]
        remarks.append(f"{poses.source}: {counted(count, 'pose')} in map units, not metres: below the frame {frame}")
    return remarks
