#!/usr/bin/env python3
"""Makes a faulted copy of a sequence and logs in OUT/faults.csv what was done to which frame."""

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from judge.venv import enter_venv, run_main  # noqa: E402


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog="Kinds: dark, saturated, frozen, torn, bits, dropped.")
    parser.add_argument("sequence", metavar="SEQ", type=pathlib.Path, help="sequence folder")
    parser.add_argument("out", metavar="OUT", type=pathlib.Path, help="folder to write, not there yet")
    parser.add_argument("--fraction", type=float, default=0.1, help="part of the frames that is spoiled (default 0.1)")
    parser.add_argument("--kinds", help="comma-separated (default: all)")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def main() -> int:
    options = arguments()
    from faults.inject import KINDS, inject
    from judge.errors import BadInput
    from judge.sequence import read_sequence
    kinds = tuple(options.kinds.split(",")) if options.kinds else KINDS
    for kind in kinds:
        if kind not in KINDS:
            raise BadInput(f"--kinds: '{kind}' is none of {', '.join(KINDS)}")
    if not 0.0 <= options.fraction <= 0.9:
        raise BadInput(f"--fraction: {options.fraction} is outside 0 .. 0.9")
    if options.out.exists():
        raise BadInput(f"{options.out}: is there already")
    log = inject(read_sequence(options.sequence), options.out, options.fraction, kinds, options.seed)
    print(f"{len(log)} frames spoiled, {options.out / 'faults.csv'} says how")
    return 0


if __name__ == "__main__":
    enter_venv()
    run_main(main, "inject_faults")
