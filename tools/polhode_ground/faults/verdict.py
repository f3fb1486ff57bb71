"""What a run with flipped bits came to, judged by its packets and by the truth."""

import dataclasses

import numpy as np
from polhode_bus.packets import EVENTS

from polhode_ground.common.tables import Motion
from polhode_ground.faults.service import Start
from polhode_ground.judge import align

# Wrong, and said to be right: what no run may publish.
ERROR_DEG = 5.0
SIGMA_DEG = 2.0
# Frames of one T before the flips that are enough to lay it over the truth.
ALIGN_FRAMES = 5
FRAMES_TO_POSE_MAX = 3
# Events that begin a frame T, a map begun and one begun anew after a loss; and the scrubber's.
ID = {name: number for number, (name, *_) in EVENTS.items()}
TARGET_ACQUIRED, TARGET_FRAME_NEW, TABLE_DAMAGED = ID["target_acquired"], ID["target_frame_new"], ID["table_damaged"]
KINDS = ("clean", "reset", "crash", "hang", "wrong pose")


@dataclasses.dataclass
class Pose:
    """Of a frame, in a frame T that is counted through all starts of a run."""

    target_frame: int
    timestamp_ns: int
    q_CT: list[float]
    sigma_deg: float


def poses_of(starts: list[Start]) -> list[Pose]:
    poses, target_frame = [], 0
    for start in starts:
        target_frame += 0 if start.warm else 1
        begun_ns = [
            packet.timestamp_ns for packet in start.packets if packet.name == "event" and packet.id in (TARGET_ACQUIRED, TARGET_FRAME_NEW)
        ]
        for packet in start.packets:
            if packet.name == "motion" and packet.q_CT is not None:
                number = target_frame + sum(time_ns <= packet.timestamp_ns for time_ns in begun_ns)
                poses.append(Pose(number, packet.timestamp_ns, packet.q_CT, float(np.degrees(packet.sigma_att_rad))))
        target_frame += len(begun_ns)
    return poses


def wrong_poses(poses: list[Pose], truth: Motion, flipped_ns: int) -> list[dict]:
    """Each T is laid over the truth by its poses from before the flips; one that began later, by all of its poses."""
    true_q = {int(time_ns): q for time_ns, q in zip(truth.timestamp_ns, truth.q_CT)}
    wrong = []
    for number in sorted({pose.target_frame for pose in poses}):
        mine = [pose for pose in poses if pose.target_frame == number and pose.timestamp_ns in true_q]
        before = [pose.timestamp_ns < flipped_ns for pose in mine]
        by = np.array(before if sum(before) >= ALIGN_FRAMES else [True] * len(mine))
        if len(mine) < 2:
            continue
        R_CE = align.rotations(np.array([pose.q_CT for pose in mine]))
        R_CT = align.rotations(np.array([true_q[pose.timestamp_ns] for pose in mine]))
        error_deg = np.degrees(align.angles_rad(R_CE * align.align_rotation(R_CE[by], R_CT[by]), R_CT))
        wrong += [
            {"timestamp_ns": pose.timestamp_ns, "error_deg": round(float(error), 2), "sigma_deg": round(pose.sigma_deg, 3)}
            for pose, error in zip(mine, error_deg)
            if error > ERROR_DEG and pose.sigma_deg < SIGMA_DEG
        ]
    return wrong


def kind_of(starts: list[Start], wrong: list[dict], damaged: int) -> str:
    if wrong:
        return "wrong pose"
    ends = [start.end for start in starts]
    if "watchdog" in ends or "no end" in ends:
        return "hang"
    if any(start.failed for start in starts):
        return "crash"
    return "reset" if damaged else "clean"


def account(starts: list[Start], truth: Motion, flipped_ns: int) -> dict:
    """One run as plain data."""
    wrong = wrong_poses(poses_of(starts), truth, flipped_ns)
    events = [packet for start in starts for packet in start.packets if packet.name == "event" and packet.id == TABLE_DAMAGED]
    return {
        "kind": kind_of(starts, wrong, len(events)),
        "ends": [start.end for start in starts],
        "words": [start.last_words for start in starts if start.failed],
        "begun": [start.begun for start in starts],
        "damage_reported": [event.text for event in events],
        "wrong_poses": wrong,
        "frames": [len(start.poses_valid) for start in starts],
        "frames_to_pose": [start.poses_valid.index(True) + 1 if True in start.poses_valid else None for start in starts],
    }


def faults_of(one: dict) -> list[str]:
    """What must not be, of one run's account."""
    faults = [] if one["flipped"] else ["it ended before its bits were flipped"]
    if one["wrong_poses"]:
        faults.append("a wrong pose with a small sigma")
    if "no end" in one["ends"]:
        faults.append("a hang that the watchdog did not see")
    if one["ends"][-1] != "status 0":
        faults.append("down for good")
    for begun, end, frames, to_pose in list(zip(one["begun"], one["ends"], one["frames"], one["frames_to_pose"]))[1:]:
        late = frames >= FRAMES_TO_POSE_MAX and (to_pose or frames + 1) > FRAMES_TO_POSE_MAX
        if begun.startswith("start warm") and late:
            faults.append(f"warm, and no pose within {FRAMES_TO_POSE_MAX} frames")
        if not begun.startswith(("start warm", "start cold: ")):
            faults.append("a start that does not say how it began")
        if begun.startswith("start cold") and end == "status 0" and to_pose is None:
            faults.append("cold, and not acquired again")
    return faults


def summary(accounts: list[dict]) -> dict:
    """By number of flips."""
    by_flips = {}
    for flips in sorted({one["flips"] for one in accounts}):
        mine = [one for one in accounts if one["flips"] == flips]
        again = [place for one in mine for place in range(1, len(one["begun"]))]
        warm = [
            one["frames_to_pose"][place]
            for one in mine
            for place in range(1, len(one["begun"]))
            if one["begun"][place].startswith("start warm")
        ]
        by_flips[str(flips)] = {
            "runs": len(mine),
            **{kind: sum(one["kind"] == kind for one in mine) for kind in KINDS},
            "starts_again": len(again),
            "warm": len(warm),
            "frames_to_pose_warm": sorted(f or 99 for f in warm),
            "faults": [f"run {one['run']}: {fault}" for one in mine for fault in faults_of(one)],
        }
    return by_flips


def text_of(by_flips: dict) -> str:
    rows = [
        f"{'flips':>6} {'runs':>5} "
        + " ".join(f"{kind:>10}" for kind in KINDS)
        + f" {'started again':>14} {'warm':>5} {'frames to a pose':>17}  faults"
    ]
    for flips, one in by_flips.items():
        late = max(one["frames_to_pose_warm"], default=0)
        rows.append(
            f"{flips:>6} {one['runs']:>5} "
            + " ".join(f"{one[kind]:>10}" for kind in KINDS)
            + f" {one['starts_again']:>14} {one['warm']:>5} {late or '-':>17}  {len(one['faults'])}"
        )
    return "\n".join(rows + [fault for one in by_flips.values() for fault in one["faults"]])
