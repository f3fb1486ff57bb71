"""The first packet and field in which two bus streams differ.

    tools/first_difference.py EXPECTED.ccsds FOUND.ccsds

Exit status 0: the same octets; 1: they differ; 2: one of them cannot be read.
"""

import argparse
import json
import os
import pathlib
import shlex
import subprocess

from polhode_ground.common.errors import BadInput
from polhode_ground.common.program import PROGRAM
from polhode_ground.common.venv import run_main

COMMAND = [*shlex.split(os.environ.get("POLHODE_RUNNER", "")), PROGRAM]  # an emulator before a program of another architecture


def packets(file: pathlib.Path) -> list[dict]:
    """@raises BadInput with the program's own words where it finds no packets."""
    try:
        dump = subprocess.run([*COMMAND, "bus", "dump", file, "--json"], capture_output=True, text=True, errors="backslashreplace")
    except OSError as problem:
        raise BadInput(f"{COMMAND[0]}: {problem.strerror}") from None
    if dump.returncode != 0:
        raise BadInput(" ".join(dump.stderr.strip().splitlines()[-1:]) or f"{file}: bus dump ended with {dump.returncode}")
    return [json.loads(line) for line in dump.stdout.splitlines() if line.strip()]


def flat(value, name: str = "") -> dict:
    """{"q_CT[0]": ..., "mode": ...}: one entry a number."""
    if isinstance(value, dict):
        return {k: v for key, part in value.items() for k, v in flat(part, f"{name}.{key}" if name else key).items()}
    if isinstance(value, list):
        return {k: v for i, part in enumerate(value) for k, v in flat(part, f"{name}[{i}]").items()}
    return {name: value}


def octets(file: pathlib.Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as problem:
        raise BadInput(f"{file}: {problem.strerror}") from None


def first_difference(expected: list[dict], found: list[dict]) -> str | None:
    for number, (a, b) in enumerate(zip(expected, found)):
        left, right = flat(a), flat(b)
        for field in [*left, *(key for key in right if key not in left)]:
            if left.get(field) != right.get(field):
                others = sum(left.get(key) != right.get(key) for key in {*left, *right}) - 1
                return (
                    f"packet {number}, {field}: expected {left.get(field)!r}, found {right.get(field)!r}"
                    f" ({others} other fields of this packet differ too)"
                )
    if len(expected) != len(found):
        return f"packet {min(len(expected), len(found))}: expected {len(expected)} packets, found {len(found)}"
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("expected", metavar="EXPECTED.ccsds", type=pathlib.Path)
    parser.add_argument("found", metavar="FOUND.ccsds", type=pathlib.Path)
    arguments = parser.parse_args()
    if octets(arguments.expected) == octets(arguments.found):
        print("the same octets")
        return 0
    print(
        first_difference(packets(arguments.expected), packets(arguments.found))
        or "all fields are the same, the octets are not: headers or check sums differ"
    )
    return 1


def command() -> None:
    run_main(main, "first_difference")
