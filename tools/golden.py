#!/usr/bin/env python3
"""The bus stream of the sample as this version is known to give it, for each architecture.

    tools/golden.py check     replays the sample; says in which packet and field it differs from what is recorded
    tools/golden.py record    replays it and records the stream

A recorded stream may change with a change of the estimator, of its defaults or of the bus layout: record anew, and say in the
commit what moved and why the new stream is as good. It must not change with the compiler's version, the machine's load, the
number of cores or the environment: that is a fault to be found, not recorded. The libraries choose their arithmetic by the
processor's vector units (fused multiply-add rounds once): a stream is compared on processors that have the recorded ones.
"""

import hashlib
import pathlib
import platform
import subprocess
import sys
import tempfile

from first_difference import PROGRAM, REPOSITORY, first_difference, packets

GOLDEN = REPOSITORY / "tests/golden" / platform.machine()
SAMPLE = REPOSITORY / "hil/data/sample"
UNITS = GOLDEN / "vector_units.txt"
CONFIGURATIONS = {"default": [], "jobs_beside": ["--set", "jobs.delay_frames=1"]}


def vector_units() -> str:
    """Those of this processor, from the kernel's list."""
    words = set()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.lower().startswith(("flags", "features")):
            words.update(line.split(":", 1)[1].split())
    return " ".join(sorted(word for word in words if word.startswith(("sse", "ssse", "avx", "fma", "asimd", "sve"))))


def comparable() -> bool:
    return UNITS.exists() and UNITS.read_text().split() == vector_units().split()


def stream(arguments: list[str], folder: pathlib.Path) -> pathlib.Path:
    subprocess.run([PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", SAMPLE,
                    "--out", folder, *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return folder / "bus.ccsds"


def compare(name: str, found: pathlib.Path) -> bool:
    expected = GOLDEN / f"{name}.ccsds"
    if not expected.exists():
        print(f"{name}: nothing is recorded for {platform.machine()}")
        return False
    if expected.read_bytes() == found.read_bytes():
        print(f"{name}: {hashlib.sha256(found.read_bytes()).hexdigest()}, as recorded")
        return True
    print(f"{name}: {first_difference(packets(expected), packets(found)) or 'headers or check sums differ'}")
    return False


def main() -> int:
    if sys.argv[1:] not in (["check"], ["record"]):
        print(__doc__, file=sys.stderr)
        return 2
    good = True
    if sys.argv[1] == "check" and not comparable():
        print(f"recorded with other vector units: {UNITS}")
    with tempfile.TemporaryDirectory() as scratch:
        for name, arguments in CONFIGURATIONS.items():
            found = stream(arguments, pathlib.Path(scratch) / name)
            if sys.argv[1] == "record":
                GOLDEN.mkdir(parents=True, exist_ok=True)
                (GOLDEN / f"{name}.ccsds").write_bytes(found.read_bytes())
                UNITS.write_text(vector_units() + "\n")
                print(f"{name}: {hashlib.sha256(found.read_bytes()).hexdigest()}, recorded")
            else:
                good = compare(name, found) and good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
