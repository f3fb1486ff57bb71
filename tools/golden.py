#!/usr/bin/env python3
"""The bus stream of the sample as this version is known to give it, for each architecture.

    tools/golden.py check     replays the sample; says in which packet and field it differs from what is recorded
    tools/golden.py record    replays it and records the stream; where it is as recorded, that these vector units give it, too

A recorded stream may change with a change of the estimator, of its defaults or of the bus layout: record anew, and say in the
commit what moved and why the new stream is as good. It must not change with the compiler's version, the machine's load, the
number of cores or the environment: that is a fault to be found, not recorded. The C library chooses its arithmetic by the
processor's vector units (fused multiply-add rounds once): a stream is compared on processors that have the recorded ones.
The stream `without_fma` is made without that choice (docs/resources.md). Ceres divides long sums by the processor's caches: all streams
are compared where those are as recorded.

The architecture is the program's: POLHODE_PROGRAM names another than build/release/bin/polhode, POLHODE_RUNNER the command that
runs one of another architecture (tools/check_arm64.sh).
"""

import argparse
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

from first_difference import COMMAND, PROGRAM, REPOSITORY, first_difference, packets
from judge.venv import run_main

SAMPLE = REPOSITORY / "hil/data/sample"
# What OpenCV compiles its code for more than once (AVX512_SKX is the last five), and the C library its mathematics.
CHOSEN_BY = {"sse4_1", "sse4_2", "avx", "fma", "avx2", "avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"}
ELF_MACHINES = {62: "x86_64", 183: "aarch64"}
CONFIGURATIONS = {"default": [], "jobs_beside": ["--set", "jobs.delay_frames=1"], "without_fma": []}
# The C library's functions as processors without fused multiply-add have them. Others than these choose nothing that rounds.
ENVIRONMENTS = {"without_fma": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"}}


def architecture() -> str:
    """That of the program, from its header."""
    with PROGRAM.open("rb") as file:
        return ELF_MACHINES[int.from_bytes(file.read(20)[18:], "little")]


def recorded() -> pathlib.Path:
    return REPOSITORY / "tests/golden" / architecture()


def vector_units() -> str:
    """Those of this processor, from the kernel's list, by which the distribution's libraries choose their arithmetic. For arm64
    they are built for asimd, which every processor has, and choose nothing."""
    if architecture() == "aarch64":
        return "asimd"
    words = set()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("flags"):
            words.update(line.split(":", 1)[1].split())
    return " ".join(sorted(words & CHOSEN_BY))


def caches() -> str:
    """Octets of the first level's for data and of the second level's, as Eigen asks for them; for arm64 it takes fixed ones."""
    if architecture() == "aarch64":
        return "fixed"
    return " ".join(subprocess.check_output(["getconf", name], text=True).strip() for name in ("LEVEL1_DCACHE_SIZE", "LEVEL2_CACHE_SIZE"))


def processor() -> str:
    return f"{vector_units()}; caches {caches()}"


def known_processors() -> list[str]:
    """Processors that are known to give what is recorded, one a line."""
    known = recorded() / "vector_units.txt"
    return known.read_text().splitlines() if known.exists() else []


def comparable(name: str = "default") -> bool:
    if name in ENVIRONMENTS:
        return any(known.endswith(f"; caches {caches()}") for known in known_processors())
    return processor() in known_processors()


def names() -> list[str]:
    """Streams of this architecture: for arm64 no library chooses anything."""
    return [name for name in CONFIGURATIONS if architecture() == "x86_64" or name not in ENVIRONMENTS]


def stream(name: str, folder: pathlib.Path) -> pathlib.Path:
    subprocess.run([*COMMAND, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", SAMPLE,
                    "--out", folder, *CONFIGURATIONS[name]], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                   env={**os.environ, **ENVIRONMENTS.get(name, {})})
    return folder / "bus.ccsds"


def compare(name: str, found: pathlib.Path) -> bool:
    expected = recorded() / f"{name}.ccsds"
    if not expected.exists():
        print(f"{name}: nothing is recorded for {architecture()}")
        return False
    if expected.read_bytes() == found.read_bytes():
        print(f"{name}: {hashlib.sha256(found.read_bytes()).hexdigest()}, as recorded")
        return True
    print(f"{name}: {first_difference(packets(expected), packets(found)) or 'headers or check sums differ'}")
    return False


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("check", "record"))
    what = parser.parse_args().what
    good = True
    same = True
    if what == "check" and not comparable():
        print(f"recorded with another processor than {processor()}")
    with tempfile.TemporaryDirectory() as scratch:
        for name in names():
            found = stream(name, pathlib.Path(scratch) / name)
            if what == "record":
                recorded().mkdir(parents=True, exist_ok=True)
                expected = recorded() / f"{name}.ccsds"
                known = expected.exists() and expected.read_bytes() == found.read_bytes()
                same = same and (known or name in ENVIRONMENTS)
                expected.write_bytes(found.read_bytes())
                print(f"{name}: {hashlib.sha256(found.read_bytes()).hexdigest()}, {'as' if known else 'newly'} recorded")
            else:
                good = compare(name, found) and good
    if what == "record":
        others = known_processors() if same else []
        (recorded() / "vector_units.txt").write_text("".join(f"{one}\n" for one in sorted({*others, processor()})))
    return 0 if good else 1


if __name__ == "__main__":
    run_main(main, "golden")
