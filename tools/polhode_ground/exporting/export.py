"""Writes the poses of a run as flight dynamics, SPICE or ROS 2 read them.

DIR is the output folder of a replay, or run.folder of a live run (its packets are read).
  aem      Attitude Ephemeris Message (CCSDS 504.0-B-2): all attitudes, from C to T
  apm      Attitude Parameter Message (CCSDS 504.0-B-2): one attitude
  oem      Orbit Ephemeris Message (CCSDS 502.0-B-3): place and velocity of T's origin in C, km, with covariances
  ck       SPICE C-kernel, with frame, clock and leap second kernels (.tf .tsc .tls) beside it
  rosbag2  a ROS 2 bag (MCAP): PoseWithCovarianceStamped, TF, angular velocity, cloud.ply as PointCloud2

Frames: C is the camera (x right, y down, z forward), T the target's body frame (docs/frames.md). Each frame T has a name of its own, and the
T of motion_smoothed.csv is another than that of motion.csv: its number has 100 added.
Gaps: a frame without a pose, another T or a longer interval ends a segment. Nothing is interpolated over them, nothing predicted is written.
Covariances: those of the packets beside motion.csv, else by the sigmas. Formats without them have the sigmas as a comment.
Times: stamps are taken for Unix time (UTC), to the nanosecond; --clock tai for a clock that counts TAI.

Examples:
  tools/export.py DIR --format aem
  tools/export.py DIR --format oem --out target.xml --target-id 1998-067A
  tools/export.py DIR --format ck --smoothed --out target.bc
  tools/export.py DIR --format rosbag2
"""

import argparse
import pathlib
import sys

from polhode_ground.common.venv import enter_venv, run_main

FORMATS = {"aem": ".aem", "apm": ".apm", "oem": ".oem", "ck": ".bc", "rosbag2": "_rosbag2"}
ONLY_FOR = {
    "frame": ("apm",),
    "rates": ("aem", "apm", "ck"),
    "metres_per_unit": ("oem", "rosbag2"),
    "gap_s": ("aem", "oem", "ck"),
    "naif_id": ("ck",),
}


def arguments() -> argparse.Namespace:
    from polhode_ground.common.ranges import number, whole
    from polhode_ground.exporting.times import CLOCKS

    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 made; 2 unusable input (one line says which).",
    )
    parser.add_argument("run", metavar="DIR", type=pathlib.Path, help="output folder of a replay or of a live run")
    parser.add_argument("--format", required=True, choices=FORMATS)
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=pathlib.Path,
        help="aem, apm and oem: XML where its name ends in .xml, else KVN; rosbag2: a folder (default: DIR/motion.aem, "
        "DIR/motion_smoothed.bc and so on)",
    )
    parser.add_argument(
        "--smoothed",
        action="store_true",
        help="motion_smoothed.csv, estimated again from all frames, and not motion.csv, which is what flew (rosbag2 has both without this)",
    )
    parser.add_argument(
        "--clock",
        choices=CLOCKS,
        default="utc",
        help="what the stamps count: utc: Unix time; tai: all seconds since 1970-01-01T00:00:00 TAI (default: utc)",
    )
    parser.add_argument(
        "--rates",
        action="store_true",
        help="aem, apm, ck: angular velocities, too. They are relative to inertial space, these formats' to the camera: you state that it does not rotate",
    )
    parser.add_argument(
        "--metres-per-unit", metavar="M", type=number(1e-9, 1e9), help="oem, rosbag2: metres of a map unit, where the run knows no scale"
    )
    parser.add_argument(
        "--gap-s", metavar="S", type=number(1e-9, 1e9), help="aem, oem, ck: a longer interval ends a segment (default: 1.5 usual intervals)"
    )
    parser.add_argument("--frame", metavar="N", type=whole(0), help="apm: number of the frame, from 0 (default: the last one with a pose)")
    add_names(parser)
    return parser.parse_args()


def add_names(parser: argparse.ArgumentParser) -> None:
    """What the message calls things."""
    from polhode_ground.common.ranges import whole
    from polhode_ground.exporting.names import name

    parser.add_argument("--target", metavar="NAME", type=name, default="TARGET", help="name of the target (default: TARGET)")
    parser.add_argument(
        "--target-id", metavar="ID", type=name, default="UNKNOWN", help="international designator, as 1998-067A (default: UNKNOWN)"
    )
    parser.add_argument(
        "--servicer", metavar="NAME", type=name, default="SERVICER", help="name of what carries the camera (default: SERVICER)"
    )
    parser.add_argument(
        "--camera-frame",
        metavar="NAME",
        type=name,
        default="CAMERA",
        help="name of C (default: CAMERA). A sensor's name of SANA's registry, as SENSOR_1, makes Orekit take attitudes the other way",
    )
    parser.add_argument(
        "--body-frame", metavar="NAME", type=name, default="SC_BODY", help="name of T, whose number follows: SC_BODY_1 (default: SC_BODY)"
    )
    parser.add_argument("--originator", metavar="NAME", type=name, default="POLHODE", help="who sends the message (default: POLHODE)")
    parser.add_argument(
        "--naif-id",
        metavar="ID",
        type=whole(-9999, -1),
        help="ck: NAIF's number of the target; one for each run, where they are loaded together (default: -999)",
    )


def check_options(asked: argparse.Namespace) -> None:
    from polhode_ground.common.errors import BadInput

    for option, formats in ONLY_FOR.items():
        if getattr(asked, option) not in (None, False) and asked.format not in formats:
            raise BadInput(f"--{option.replace('_', '-')}: is for --format {', '.join(formats)}, not {asked.format}")


def poses_of(asked: argparse.Namespace, kind: str):
    from polhode_ground.exporting.poses import in_metres, read_poses

    poses = read_poses(asked.run, kind)
    return poses if asked.metres_per_unit is None else in_metres(poses, asked.metres_per_unit)


def write_message(asked: argparse.Namespace, names, out: pathlib.Path, gap_ns: int | None) -> tuple[str, list[str]]:
    from polhode_ground.common.whole_file import check_replaceable, write_whole
    from polhode_ground.exporting.ccsds import WRITERS, Message, text_of

    check_replaceable(out)
    poses = poses_of(asked, "smoothed" if asked.smoothed else "causal")
    message, what, remarks = WRITERS[asked.format](poses, Message(names, asked.clock, gap_ns, asked.rates, asked.frame))
    write_whole(out, text_of(message, "xml" if out.suffix.lower() == ".xml" else "kvn"))
    return what, remarks + clock_remarks(asked, poses)


def write_kernels(asked: argparse.Namespace, names, out: pathlib.Path, gap_ns: int | None) -> tuple[str, list[str]]:
    from polhode_ground.exporting.kernels import write_ck

    poses = poses_of(asked, "smoothed" if asked.smoothed else "causal")
    naif_id = -999 if asked.naif_id is None else asked.naif_id
    what, remarks = write_ck(poses, out, names, naif_id, asked.clock, gap_ns, asked.rates)
    return what, remarks + clock_remarks(asked, poses)


def write_bag(asked: argparse.Namespace, out: pathlib.Path) -> tuple[str, list[str]]:
    from polhode_ground.exporting.ros_bag import write_rosbag2
    from polhode_ground.judge.run import MOTION_FILES

    both = not asked.smoothed and (asked.run / MOTION_FILES["smoothed"]).exists()
    kinds = ["smoothed"] if asked.smoothed else ["causal", "smoothed"] if both else ["causal"]
    motions = [poses_of(asked, kind) for kind in kinds]
    what, said = write_rosbag2(motions, asked.run, out, asked.metres_per_unit)
    remarks = [f"{poses.source}: {remark}" for poses in motions for remark in poses.remarks] + said + clock_remarks(asked, motions[0])
    return what, remarks + (["times are the stamps as they are, which ROS takes for UTC"] if asked.clock == "tai" else [])


def clock_remarks(asked: argparse.Namespace, poses) -> list[str]:
    from polhode_ground.exporting.times import doubt_of

    doubt = doubt_of(poses.time_ns[0])
    return ([doubt] if doubt else []) + ([] if asked.format == "rosbag2" else [f"times are {asked.clock.upper()} (--clock)"])


def main() -> int:
    asked = arguments()
    from polhode_ground.exporting.names import Names

    check_options(asked)
    names = Names(asked.target, asked.target_id, asked.servicer, asked.camera_frame, asked.body_frame, asked.originator)
    stem = "motion_smoothed" if asked.smoothed else "motion"
    out = asked.out or asked.run / f"{stem}{FORMATS[asked.format]}"
    gap_ns = None if asked.gap_s is None else round(asked.gap_s * 1e9)
    if asked.format == "rosbag2":
        what, remarks = write_bag(asked, out)
    else:
        what, remarks = (write_kernels if asked.format == "ck" else write_message)(asked, names, out, gap_ns)
    print(f"{out}: {what}")
    for remark in remarks:
        print(f"export: {remark}", file=sys.stderr)
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "export")
