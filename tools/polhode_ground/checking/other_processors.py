"""The sample's bus stream on processors that this machine has not: replayed under QEMU and compared with what is recorded.

    tools/other_processors.py                            six models, `default` and `full`: some 50 minutes on two cores
    tools/other_processors.py --models Nehalem Haswell --configurations default

The models differ in what the libraries choose by: vector units, fused multiply-add, sizes of caches. One line a replay; status 1
where a stream is another than the recorded one. tools/setup.sh processors installs the emulator.
"""

import argparse
import concurrent.futures
import os
import pathlib
import shutil
import tempfile
import time

from polhode_ground.checking import golden
from polhode_ground.common.errors import BadInput
from polhode_ground.common.ranges import whole
from polhode_ground.common.venv import run_main

EMULATOR = "qemu-x86_64-static"
# From the least to one with AVX-512, of two makers; `max` is all that the emulator has.
MODELS = ("Nehalem", "Haswell", "Skylake-Server", "EPYC", "Denverton", "max")


def replay(model: str, name: str, folder: pathlib.Path) -> bool:
    """Whether that model gives the recorded stream; says so, and how long it took."""
    begun = time.monotonic()
    same, line = golden.compare(name, golden.stream(name, folder / f"{model}_{name}", (EMULATOR, "-cpu", model)))
    print(f"{model}, {(time.monotonic() - begun) / 60:.0f} min: {line}", flush=True)
    return same


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--models", nargs="+", default=MODELS, metavar="MODEL", help=f"default: {' '.join(MODELS)}; more: {EMULATOR} -cpu help"
    )
    parser.add_argument("--configurations", nargs="+", choices=golden.CONFIGURATIONS, default=["default", "full"])
    parser.add_argument("--jobs", type=whole(1, 256), default=os.cpu_count(), help="replays at a time (default: one a core)")
    asked = parser.parse_args()
    if golden.architecture() != "x86_64":
        raise BadInput(f"the program is built for {golden.architecture()}; tools/check_arm64.sh runs that")
    if not shutil.which(EMULATOR):
        raise BadInput(f"{EMULATOR} is not installed: tools/setup.sh processors")
    wanted = [(model, name) for name in asked.configurations for model in asked.models]
    print(f"{len(wanted)} replays, {asked.jobs} at a time, 5 to 10 min each", flush=True)
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        same = list(pool.map(lambda one: replay(*one, pathlib.Path(scratch)), wanted))
    print(f"{sum(same)} of {len(same)} as recorded")
    return 0 if all(same) else 1


def command() -> None:
    run_main(main, "other_processors")
