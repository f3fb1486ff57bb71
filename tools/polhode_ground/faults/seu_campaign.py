"""Flips bits in the tables of a live run at drawn frames, as radiation does, and tells what came of it.

usage: seu_campaign.py FOLDER [--runs 20] [--flips 64,1024] [--seed 1] [--watchdog-s 10]
The sample is played, a checkpoint is written now and then. At a drawn frame the program is stopped, that many drawn bits of
its tables are flipped, and it goes on. A run that crashes or hangs is started again, as a service manager would, with the
frames that come after. What a run came to:

    clean       nothing was to be seen
    reset       a table was found damaged, and reset or rebuilt
    crash       it ended by a signal or a status other than 0, and was started again
    hang        it told of no progress, and was ended by the watchdog
    wrong pose  an attitude off by more than 5 deg with a sigma under 2

The same seed draws the same frames and bits. FOLDER, not there yet, receives campaign.json and what the runs with a fault
wrote. Status 1 for a wrong pose, a hang that the watchdog does not see, a run that does not come back, and a warm start
without a valid pose within three frames.

examples:
    hil/seu_campaign.py /tmp/flips                                     20 runs with 64 and 20 with 1024 flips, 5 minutes
    hil/seu_campaign.py /tmp/flips --runs 1 --flips 0                  a control: nothing is flipped
    hil/seu_campaign.py /tmp/flips --runs 300 --flips 1,16,256,4096    the whole range, some hours
"""

import argparse
import json
import pathlib
import random
import shutil
import signal
import time

from polhode_ground.common.program import PROGRAM, check_program, new_folder
from polhode_ground.common.ranges import number, whole
from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main

SAMPLE = REPOSITORY / "hil/data/sample"
FLIPS_MAX = 4096
# The map begins with the fifth frame. Behind the last drawn frame a cold start still has frames enough for a map.
FRAME_FIRST, FRAME_LAST = 8, 60
CHECKPOINT_FRAMES = 5
# The sample's frames are a second apart: one passes while the program is down.
FRAMES_AWAY = 1
STARTS_MAX = 6

CONFIG = """\
[jobs]
delay_frames = 0
delay_of_all_frames = 0
[device]
source = "{sequence}"
sequence_speed = 0.0
[run]
folder = "{folder}"
checkpoint = "{checkpoint}"
checkpoint_frames = {every}
lock_memory = false
core = -1
priority = 0
"""


class Flipping:
    """Flips the bits when the drawn frame has been answered."""

    def __init__(self, frame: int, flips: int, chance: random.Random):
        self.frame, self.flips, self.chance, self.tables_octets = frame, flips, chance, 0

    def __call__(self, process, frames: int) -> bool:
        from polhode_ground.faults.tables import flip

        if frames <= self.frame:
            return False
        process.send_signal(signal.SIGSTOP)
        while pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "T":
            time.sleep(0.001)
        self.tables_octets = flip(process.pid, PROGRAM, self.flips, self.chance)
        process.send_signal(signal.SIGCONT)
        return True


def sequence_from(folder: pathlib.Path, rows: list[str], first: int) -> pathlib.Path:
    """The sample from that frame on."""
    camera = folder / "mav0/cam0"
    camera.mkdir(parents=True)
    source = SAMPLE / "mav0/cam0"
    shutil.copy(source / "sensor.yaml", camera)
    (camera / "data").symlink_to(source / "data")
    (camera / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows[first:]]) + "\n")
    return folder


def one_run(folder: pathlib.Path, flipping: Flipping, rows: list[str], watchdog_s: float) -> list:
    """@return its starts; the last one came to the end of the frames, or the run stays down."""
    from polhode_ground.faults.service import run

    folder.mkdir()
    starts, first = [], 0
    while first < len(rows) and len(starts) < STARTS_MAX:
        place = folder / f"start{len(starts)}"
        config = folder / f"start{len(starts)}.toml"
        config.write_text(
            CONFIG.format(
                sequence=sequence_from(folder / f"frames{len(starts)}", rows, first),
                folder=place,
                checkpoint=folder / "checkpoint",
                every=CHECKPOINT_FRAMES,
            )
        )
        starts.append(run([PROGRAM, "run", "--config", config], place, watchdog_s, None if starts else flipping))
        if not starts[-1].failed:
            break
        first += len(starts[-1].poses_valid) + 1 + FRAMES_AWAY  # the one that it fell over is lost, too
    return starts


def campaign(folder: pathlib.Path, runs: int, all_flips: list[int], seed: int, watchdog_s: float) -> list[dict]:
    from polhode_ground.common.tables import read_motion
    from polhode_ground.faults.verdict import account, faults_of

    truth = read_motion(SAMPLE / "truth.csv")
    rows = (SAMPLE / "mav0/cam0/data.csv").read_text().splitlines()[1:]
    accounts = []
    for drawn in range(runs * len(all_flips)):
        flips = all_flips[drawn % len(all_flips)]
        chance = random.Random(f"{seed}/{drawn}")
        flipping = Flipping(chance.randint(FRAME_FIRST, FRAME_LAST), flips, chance)
        begun_s = time.monotonic()
        starts = one_run(folder / f"run{drawn:04d}", flipping, rows, watchdog_s)
        one = {
            "run": drawn,
            "flips": flips,
            "frame": flipping.frame,
            "flipped": flipping.tables_octets > 0,
            **account(starts, truth, int(rows[flipping.frame].split(",")[0])),
            "seconds": round(time.monotonic() - begun_s, 1),
        }
        accounts.append(one)
        if not faults_of(one):
            shutil.rmtree(folder / f"run{drawn:04d}")
        print(
            f"{drawn:4d}  {flips:4d} flips at frame {flipping.frame:2d}: {one['kind']}; {', '.join(one['ends'])}"
            + "".join(f"; {fault}" for fault in faults_of(one)),
            flush=True,
        )
        (folder / "campaign.json").write_text(
            json.dumps({"seed": seed, "tables_octets": flipping.tables_octets, "runs": accounts}, indent=1)
        )
    return accounts


def flips_list(text: str) -> list[int]:
    return [whole(0, FLIPS_MAX)(word) for word in text.split(",")]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER", help="not there yet")
    parser.add_argument("--runs", type=whole(1), default=20, help="of each number of flips")
    parser.add_argument("--flips", type=flips_list, default=[64, 1024], metavar="N,N", help=f"bits of a run, 0 .. {FLIPS_MAX}")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--watchdog-s", type=number(1.0, 3600.0), default=10.0, help="as in polhode.service; more on a busy machine")
    asked = parser.parse_args()
    check_program()
    from polhode_ground.faults.tables import symbol_address
    from polhode_ground.faults.verdict import summary, text_of

    symbol_address(PROGRAM)
    accounts = campaign(new_folder(asked.folder), asked.runs, asked.flips, asked.seed, asked.watchdog_s)
    by_flips = summary(accounts)
    file = asked.folder / "campaign.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "by_flips": by_flips}, indent=1))
    print(text_of(by_flips))
    return 1 if any(one["faults"] for one in by_flips.values()) else 0


def command() -> None:
    enter_venv()
    run_main(main, "seu_campaign")
