"""The bus stream of the sample as this version is known to give it, for each architecture.

    tools/golden.py check     replays the sample; says in which packet and field it differs from what is recorded
    tools/golden.py record    replays it and records the stream

A recorded stream may change with a change of the estimator, of its defaults or of the bus layout: record anew, and say in the
commit what moved and why the new stream is as good. It must not change with the compiler's version, the machine's load, the
number of cores, the environment or the processor: that is a fault to be found, not recorded. tools/other_processors.py replays
the sample on six more.

The architecture is the program's: POLHODE_PROGRAM names another than build/release/bin/polhode, POLHODE_RUNNER the command that
runs one of another architecture (tools/check_arm64.sh).
"""

import argparse
import hashlib
import pathlib
import subprocess
import tempfile

from polhode_ground.checking.first_difference import COMMAND, PROGRAM, first_difference, packets
from polhode_ground.common.venv import REPOSITORY, run_main

SAMPLE = REPOSITORY / "hil/data/sample"
ELF_MACHINES = {62: "x86_64", 183: "aarch64"}
CONFIGURATIONS = {"default": ("default", []), "jobs_beside": ("default", ["--set", "jobs.delay_frames=1"]), "full": ("full", [])}


def architecture() -> str:
    """That of the program, from its header."""
    with PROGRAM.open("rb") as file:
        return ELF_MACHINES[int.from_bytes(file.read(20)[18:], "little")]


def recorded() -> pathlib.Path:
    return REPOSITORY / "tests/golden" / architecture()


def stream(name: str, folder: pathlib.Path, runner: tuple = ()) -> pathlib.Path:
    """The stream of a replay into FOLDER. `runner` is a command before the program's, as an emulator."""
    configuration, settings = CONFIGURATIONS[name]
    subprocess.run(
        [
            *runner,
            *COMMAND,
            "replay",
            "--config",
            REPOSITORY / f"config/{configuration}.toml",
            "--sequence",
            SAMPLE,
            "--out",
            folder,
            *settings,
        ],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return folder / "bus.ccsds"


def compare(name: str, found: pathlib.Path) -> tuple[bool, str]:
    """Whether it is the recorded stream, and a line that says so or where they part."""
    expected = recorded() / f"{name}.ccsds"
    if not expected.exists():
        return False, f"{name}: nothing is recorded for {architecture()}"
    if expected.read_bytes() == found.read_bytes():
        return True, f"{name}: {hashlib.sha256(found.read_bytes()).hexdigest()}, as recorded"
    return False, f"{name}: {first_difference(packets(expected), packets(found)) or 'headers or check sums differ'}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("check", "record"))
    what = parser.parse_args().what
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        for name in CONFIGURATIONS:
            found = stream(name, pathlib.Path(scratch) / name)
            if what == "record":
                recorded().mkdir(parents=True, exist_ok=True)
                expected = recorded() / f"{name}.ccsds"
                known = expected.exists() and expected.read_bytes() == found.read_bytes()
                expected.write_bytes(found.read_bytes())
                print(f"{name}: {hashlib.sha256(found.read_bytes()).hexdigest()}, {'as' if known else 'newly'} recorded")
            else:
                same, line = compare(name, found)
                print(line)
                good = good and same
    return 0 if good else 1


def command() -> None:
    run_main(main, "golden")
