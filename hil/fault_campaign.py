#!/usr/bin/env python3
"""Spoils 10 % of the frames of sequences, replays them, and says what became of it: coverage of the good frames, wrong poses
of bad ones, counters beside what was injected. Several seeds a sequence; the last line has the verdict of all."""

import argparse
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from judge.ranges import number, whole  # noqa: E402
from judge.venv import REPOSITORY, enter_venv, run_main  # noqa: E402

COVERAGE_MIN = 0.95
COUNTER_ERROR_MAX = 0.05


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sequences", metavar="SEQ", type=pathlib.Path, nargs="+")
    parser.add_argument("--out", metavar="DIR", type=pathlib.Path, required=True, help="working folder, not there yet")
    parser.add_argument("--seeds", type=whole(1), default=3, help="runs a sequence (default 3)")
    parser.add_argument("--fraction", type=number(0.0, 0.9), default=0.1, help="part of the frames that is spoiled (default 0.1)")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="passed on to the replay")
    parser.add_argument("--program", type=pathlib.Path, default=REPOSITORY / "build/release/bin/polhode")
    return parser.parse_args()


def one_run(options, folder, seed):
    from faults.inject import KINDS, inject
    from faults.verdict import judge_faulted
    from judge.replay import replay
    from judge.sequence import read_sequence
    place = options.out / f"{folder.name}_{seed}"
    inject(read_sequence(folder), place / "sequence", options.fraction, KINDS, seed)
    replay(place / "sequence", place / "run", options.set, program=options.program)
    verdict = judge_faulted(place / "run", read_sequence(place / "sequence"))
    shutil.rmtree(place / "sequence" / "mav0")
    return verdict


def describe(name: str, verdict) -> str:
    from faults.inject import KINDS
    counts = " ".join(f"{kind} {verdict.counted[kind]}/{verdict.injected[kind]}" for kind in KINDS)
    return f"{name}: coverage {verdict.coverage:.3f}, wrong poses {len(verdict.wrong_poses)}, {counts}"


def main() -> int:
    options = arguments()
    from faults.verdict import Verdict
    from judge.errors import BadInput
    if options.out.exists():
        raise BadInput(f"{options.out}: is there already")
    total = Verdict()
    for folder in options.sequences:
        for seed in range(1, options.seeds + 1):
            verdict = one_run(options, folder, seed)
            print(describe(f"{folder.name} {seed}", verdict), *verdict.wrong_poses, flush=True)
            total = total + verdict
    worst = max(total.counter_errors().values())
    held = total.coverage >= COVERAGE_MIN and not total.wrong_poses and worst <= COUNTER_ERROR_MAX
    print(describe("all", total), f"worst counter {100 * worst:.1f} %:", "held" if held else "NOT HELD")
    return 0 if held else 1


if __name__ == "__main__":
    enter_venv()
    run_main(main, "fault_campaign")
