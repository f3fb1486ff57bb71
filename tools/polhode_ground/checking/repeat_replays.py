"""One answer: replays of the same frames give the same bytes, whatever the machine does meanwhile.

    tools/repeat_replays.py [--replays 20] [--sequence hil/data/sample] [--config config/default.toml] [--set key=value ...] [--draws 1]

Each replay draws anew how many programs want the cores, which cores it may use, whether jobs have a thread of their own and how long they are held back,
its environment, its folder, its priority and whether its addresses are at random. Prints one line each; status 1 when two streams differ.
"""

import argparse
import json
import multiprocessing
import os
import random
import subprocess
import tempfile
from pathlib import Path

from polhode_ground.common.errors import BadInput
from polhode_ground.common.program import PROGRAM
from polhode_ground.common.ranges import whole
from polhode_ground.common.venv import REPOSITORY, run_main


def busy() -> None:
    octets = bytearray(1 << 24)
    while True:
        octets[::64] = bytes(len(octets) // 64)


def draw(chance: random.Random, delayed: bool) -> dict:
    """One replay's circumstances. @param delayed whether jobs are beside the steps: with a delay of 0 there is nothing to hold back."""
    cores = sorted(os.sched_getaffinity(0))
    return {
        "programs": chance.randint(0, 3),
        "cores": chance.choice([cores, cores[:1], cores[-1:]]),
        "one_core": delayed and chance.random() < 0.3,
        "latency_ms": chance.choice([0, 0, 5, 40]) if delayed else 0,
        "fixed_addresses": chance.random() < 0.3,
        "nice": chance.choice([0, 2, 5]),
        "environment": {
            "LANG": chance.choice(["C", "C.UTF-8", "de_DE.UTF-8"]),
            "TZ": chance.choice(["UTC", "Asia/Tokyo"]),
            "OMP_NUM_THREADS": str(chance.randint(1, 8)),
            "PADDING": "x" * chance.randint(0, 60000),
        },
    }


def replay(arguments: argparse.Namespace, found: dict, folder: Path) -> str:
    """@return the stream's SHA-256. @raises BadInput with the program's own words where it fails."""
    command = ["taskset", "-c", ",".join(map(str, found["cores"])), "nice", "-n", str(found["nice"])]
    if found["fixed_addresses"]:
        command += ["setarch", "-R"]
    command += [str(PROGRAM), "replay", "--config", str(arguments.config), "--sequence", str(arguments.sequence), "--out", str(folder)]
    for setting in arguments.set:
        command += ["--set", setting]
    if found["one_core"]:
        command.append("--one-core")
    if found["latency_ms"]:
        command += ["--job-latency-ms", str(found["latency_ms"])]
    programs = [multiprocessing.Process(target=busy, daemon=True) for _ in range(found["programs"])]
    try:
        for program in programs:
            program.start()
        done = subprocess.run(
            command,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            cwd=folder.parent,
            env={**os.environ, **found["environment"]},
        )
    finally:
        for program in programs:
            program.kill()
            program.join()
    if done.returncode != 0:
        raise BadInput(" ".join(done.stderr.strip().splitlines()[-1:]) or f"the replay ended with {done.returncode}")
    return json.loads((folder / "summary.json").read_text())["bus_sha256"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replays", type=whole(1), default=20)
    parser.add_argument("--sequence", type=Path, default=REPOSITORY / "hil/data/sample")
    parser.add_argument("--config", type=Path, default=REPOSITORY / "config/default.toml")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--draws", type=int, default=1, help="seed of what is drawn")
    arguments = parser.parse_args()
    arguments.sequence, arguments.config = arguments.sequence.resolve(), arguments.config.resolve()
    delayed = "jobs.delay_of_all_frames=0" not in arguments.set
    chance = random.Random(arguments.draws)
    streams = set()
    for number in range(arguments.replays):
        found = draw(chance, delayed)
        with tempfile.TemporaryDirectory(prefix="polhode" + "_" * chance.randint(0, 40)) as scratch:
            stream = replay(arguments, found, Path(scratch) / "run")
        streams.add(stream)
        environment = found.pop("environment")
        print(f"{number + 1:>3} {stream[:16]} {found} {environment['LANG']} {len(environment['PADDING'])}", flush=True)
    print(f"{arguments.replays} replays, {len(streams)} stream{'s' if len(streams) > 1 else ''}")
    return 1 if len(streams) > 1 else 0


def command() -> None:
    run_main(main, "repeat_replays")
