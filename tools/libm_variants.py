#!/usr/bin/env python3
"""Functions of the C library whose result depends on the processor: drawn arguments, with this processor's variants and with those of
one without fused multiply-add.

    tools/libm_variants.py [--draws 1000000]

One line a function: how many results differ, and by how many units in the last place at most. x86-64 only (tools/golden.py).
"""

import argparse
import array
import math
import os
import random
import subprocess
import sys

from golden import ENVIRONMENTS
from judge.ranges import whole
from judge.venv import run_main

# Name, and the ranges of its arguments.
FUNCTIONS = {"sin": [(-4, 4)], "cos": [(-4, 4)], "tan": [(-1.5, 1.5)], "asin": [(-1, 1)], "acos": [(-1, 1)], "atan": [(-10, 10)],
             "atan2": [(-1, 1), (-1, 1)], "exp": [(-20, 5)], "log": [(1e-6, 100)], "log10": [(1e-6, 100)], "log1p": [(-0.9, 10)],
             "pow": [(0.01, 10), (-3, 3)], "sinh": [(-4, 4)], "cosh": [(-4, 4)], "cbrt": [(-10, 10)]}


def results(name: str, draws: int) -> array.array:
    chance, call, ranges = random.Random(name), getattr(math, name), FUNCTIONS[name]
    return array.array("d", (call(*(chance.uniform(*one) for one in ranges)) for _ in range(draws)))


def results_elsewhere(name: str, draws: int) -> array.array:
    """By this script, started anew: the library chooses once."""
    found = array.array("d")
    done = subprocess.run([sys.executable, __file__, "--draws", str(draws), "--of", name], check=True, capture_output=True,
                          env={**os.environ, **ENVIRONMENTS["without_fma"]})
    found.frombytes(done.stdout)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=whole(1, 10**8), default=10**6, help="of each function (default 1000000)")
    parser.add_argument("--of", choices=FUNCTIONS, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.of:
        sys.stdout.buffer.write(results(asked.of, asked.draws).tobytes())
        return 0
    for name in FUNCTIONS:
        pairs = [(a, b) for a, b in zip(results(name, asked.draws), results_elsewhere(name, asked.draws)) if a != b]
        last = max((round(abs(a - b) / math.ulp(a)) for a, b in pairs), default=0)
        print(f"{name:6} {len(pairs):7} of {asked.draws} differ, by {last} units in the last place at most")
    return 0


if __name__ == "__main__":
    run_main(main, "libm_variants")
