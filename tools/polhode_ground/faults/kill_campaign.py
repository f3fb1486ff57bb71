"""Kills a live run at random moments and starts it anew, as a service manager would.

A turning body is played on and on, on the machine's clock, so that a new start finds it where it would be by then. A checkpoint is
written after every frame, so that most kills fall into the writing of one. For every start: was the checkpoint taken, how long
until the first packet, how many good frames until a valid pose. Status 1 when a checkpoint was torn, a pose came later
than with the third frame, or a start gave no packet. FOLDER, not there yet, receives the runs and campaign.json.

Examples:
  hil/kill_campaign.py FOLDER
  hil/kill_campaign.py FOLDER --kills 10 --seed 2
"""

import argparse
import json
import pathlib
import random
import signal
import subprocess
import sys
import time

from polhode_ground.common.program import PROGRAM, check_program, new_folder
from polhode_ground.common.ranges import number, whole
from polhode_ground.common.venv import enter_venv, run_main

FRAMES_TO_POSE_MAX = 3

CONFIG = """\
[features]
count_max = 250
working_pixels_max = 40000
[device]
source = "{sequence}"
sequence_speed = {speed}
sequence_passes = 100000
sequence_start_ns = {start_ns}
[run]
checkpoint = "{folder}/checkpoint"
checkpoint_frames = 1
"""


def packets(file: pathlib.Path) -> list[dict]:
    done = subprocess.run([PROGRAM, "bus", "dump", file, "--json"], capture_output=True, text=True)
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def pose_valid(packet: dict) -> bool | None:
    """None for packets of another kind."""
    return packet.get("pose_valid")


class NoPacket(Exception):
    """A start came to nothing: its text names the start and the program's last words."""


class Start:
    """One start of the program, and what came of it."""

    def __init__(self, folder: pathlib.Path, number: int, config: pathlib.Path):
        self.folder = folder / f"start{number:03d}"
        self.folder.mkdir()
        command = [PROGRAM, "run", "--config", config, "--set", f'run.folder="{self.folder}"']
        with open(self.folder / "stderr.txt", "w") as stderr:
            self.begun_s = time.monotonic()
            self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr)

    def octets(self) -> int:
        file = self.folder / "bus.ccsds"
        return file.stat().st_size if file.exists() else 0

    def wait_for_packet(self, limit_s: float = 120.0) -> float:
        """Seconds from the start to the first packet."""
        while self.octets() == 0:
            if self.process.poll() is not None or time.monotonic() - self.begun_s > limit_s:
                last = "".join((self.folder / "stderr.txt").read_text().splitlines()[-1:])
                raise NoPacket(f"{self.folder}: no packet: {last or 'the program said nothing'}")
            time.sleep(0.002)
        return time.monotonic() - self.begun_s

    def wait_for_frames(self, frames: int, limit_s: float = 300.0) -> None:
        end = time.monotonic() + limit_s
        while len(self.poses_valid()) < frames and time.monotonic() < end:
            time.sleep(0.1)

    def poses_valid(self) -> list[bool]:
        """Of each frame that has been answered."""
        return [valid for valid in map(pose_valid, packets(self.folder / "bus.ccsds")) if valid is not None]

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def account(self, first_packet_s: float) -> dict:
        said = (self.folder / "stderr.txt").read_text()
        begun = next((line for line in said.splitlines() if line.startswith("start ")), "")
        valid = self.poses_valid()
        return {
            "begun": begun,
            "first_packet_s": round(first_packet_s, 3),
            "frames": len(valid),
            "frames_to_pose": valid.index(True) + 1 if True in valid else None,
        }


def make_config(folder: pathlib.Path, interval_s: float) -> pathlib.Path:
    from polhode_ground.v4l2 import sequences

    sequence = folder / "body"
    sequences.write(sequence, sequences.body(40), 600.0)
    config = folder / "live.toml"
    config.write_text(CONFIG.format(sequence=sequence, speed=1.0 / interval_s, folder=folder, start_ns=time.monotonic_ns()))
    return config


def campaign(folder: pathlib.Path, kills: int, seed: int, interval_s: float) -> list[dict]:
    chance = random.Random(seed)
    config = make_config(folder, interval_s)
    accounts = []
    for kill in range(kills + 1):
        start = Start(folder, kill, config)
        try:
            first_s = start.wait_for_packet()
            # The first run must have a map before it is killed; the others have one from the checkpoint. Three frames at
            # least, so that there is something to judge; then any moment.
            start.wait_for_frames(12 if kill == 0 else FRAMES_TO_POSE_MAX)
            time.sleep(chance.uniform(0.0, 4.0 * interval_s))
        finally:
            start.kill()
        accounts.append(start.account(first_s))
        print(f"{kill:3d}  {accounts[-1]}", flush=True)
    return accounts


def judge(accounts: list[dict]) -> dict:
    after = accounts[1:]
    cold = [a for a in after if "warm" not in a["begun"]]
    late = [a for a in after if (a["frames_to_pose"] or 99) > FRAMES_TO_POSE_MAX]
    times = sorted(a["first_packet_s"] for a in after)
    return {
        "kills": len(after),
        "cold_starts": len(cold),
        "later_than_third_frame": len(late),
        "frames_to_pose": sorted(a["frames_to_pose"] or 99 for a in after),
        "first_packet_s": {"p50": times[len(times) // 2], "max": times[-1]},
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER", help="not there yet")
    parser.add_argument("--kills", type=whole(1), default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--interval-s", type=number(0.001, 3600.0), default=0.25, help="from frame to frame")
    asked = parser.parse_args()
    check_program()
    folder = new_folder(asked.folder)
    try:
        accounts = campaign(folder, asked.kills, asked.seed, asked.interval_s)
    except NoPacket as problem:
        print(f"kill_campaign: {problem}", file=sys.stderr)
        return 1
    verdict = judge(accounts)
    (folder / "campaign.json").write_text(json.dumps({"verdict": verdict, "starts": accounts}, indent=1))
    print(json.dumps(verdict))
    return 1 if verdict["cold_starts"] or verdict["later_than_third_frame"] else 0


def command() -> None:
    enter_venv()
    run_main(main, "kill_campaign")
