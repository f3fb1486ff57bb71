#!/usr/bin/env -S python3 -Es -X utf8
"""Gives spoilt inputs to every reader of the program, and to the tool that reads its clouds.

usage: .venv/bin/python tests/fuzz/drive.py [--trials 20000] [--seed 1] [--keep FOLDER] [--refusals FILE] [--processes 1] [--wait 1] [--memory-mb 1000]
       [--leave-out READER]...

A trial fails by a signal, a status outside 0 to 3, more than 20 s (60 s of a tool) or 1 GB, a refusal of more than one line, or one that does not name the
file. Failing inputs are kept; the same trial of the same seed is the same input. Status 1 when a trial failed.

On a busy machine a program waits for its turn: --wait 10 allows ten times as long by the clock, and the same processor time.

POLHODE_PROGRAM=build/asan-ubsan/bin/polhode tries the program of the preset asan-ubsan. What its sanitizers find ends it with status 86, a fault.
They take memory of their own: --memory-mb 2000. A live run warms up for 10 s there: --leave-out spares the trials of a reader, all others are the same.
"""

import argparse
import collections
import dataclasses
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor

from mutations import spoilt
from readers import SANITIZERS, Reader, all_readers, sequence

MEMORY_MAX_KB = 1_000_000
STATUS_MAX = 3


@dataclasses.dataclass
class Outcome:
    trial: int
    reader: str
    status: int
    seconds: float  # of the processor
    memory_kb: int
    fault: str  # empty: none
    refusal: str  # empty: none


def fault_of(status: int, seconds: float, memory_kb: int, err: bytes, names: list[str], who: str = "polhode", seconds_max: float = 20.0,
             memory_max_kb: int = MEMORY_MAX_KB) -> str:
    if not 0 <= status <= STATUS_MAX:
        return f"status {status}"
    if seconds > seconds_max:
        return f"{seconds:.0f} s"
    if memory_kb > memory_max_kb:
        return f"{memory_kb} kB"
    if status != 2:
        return ""
    told = refusals_of(err, who)
    if len(told) != 1 or b"Traceback (most recent call last):" in err:
        return "a refusal is one line"
    return "" if any(name in told[0] for name in names) else "a refusal names the file"


def refusals_of(err: bytes, who: str) -> list[str]:
    lines = err.decode(errors="backslashreplace").replace("\r", "\n").strip().splitlines()
    return [line for line in lines if line.startswith(f"{who}: ")]


def form_of(refusal: str, folder: str) -> str:
    """The same of all refusals that differ in places and values alone."""
    return re.sub(r"'[^']*'|\"[^\"]*\"", "'...'", re.sub(r"[-+]?\d[\d.]*", "0", re.sub(re.escape(folder) + r"/tmp\w+/", "", refusal)))


def execute(command: list[str], seconds_max: float) -> tuple[int, float, int, bytes]:
    """Ended after so long by the clock. @return status (negative: a signal), processor's seconds, resident kB at most, standard error."""
    with tempfile.TemporaryFile() as err:
        start = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=err, env=os.environ | SANITIZERS)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > seconds_max:
                process.kill()
            time.sleep(0.002)
        process.returncode = os.waitstatus_to_exitcode(status)  # it was waited for here
        err.seek(0)
        return process.returncode, usage.ru_utime + usage.ru_stime, usage.ru_maxrss, err.read(100_000)


def one(reader: Reader, trial: int, seed: int, folder: pathlib.Path, keep: pathlib.Path | None, wait: float,
        memory_max_kb: int = MEMORY_MAX_KB) -> Outcome:
    data = spoilt(reader.good, random.Random(f"{seed}/{trial}"), reader.sums)
    work = pathlib.Path(tempfile.mkdtemp(dir=folder))
    try:
        place = sequence_with(work, reader.place)
        for name, octets in reader.beside.items():
            (work / name).write_bytes(octets)
            (work / name).chmod(0o600)
        file = place or work / reader.file_name
        file.write_bytes(data)
        file.chmod(0o600)
        places = {"file": file, "folder": work, "sequence": work / "sequence", "out": work / "out"}
        status, seconds, memory_kb, err = execute([*reader.command, *(part.format(**places) for part in reader.arguments)], reader.seconds_max * wait)
        names = [file.name, str(work)]
        fault = fault_of(status, seconds, memory_kb, err, names, reader.who, reader.seconds_max, memory_max_kb)
        if fault and keep:
            keep.mkdir(parents=True, exist_ok=True)
            (keep / f"{trial}.{reader.name.replace(' ', '_')}").write_bytes(data)
            (keep / f"{trial}.txt").write_bytes(f"{reader.name}: {fault}\n{reader.arguments}\n".encode() + err)
        refusal = "".join(refusals_of(err, reader.who)[:1]) if status == 2 else ""
        return Outcome(trial, reader.name, status, seconds, memory_kb, fault, form_of(refusal, str(folder)))
    finally:
        shutil.rmtree(work, ignore_errors=True)


def sequence_with(work: pathlib.Path, place: str) -> pathlib.Path | None:
    """A good sequence; @return where the spoilt file belongs in it."""
    sequence(work / "sequence")
    return work / "sequence" / place if place else None


def drive(trials: int, seed: int, folder: pathlib.Path, keep: pathlib.Path | None = None, processes: int = 1, wait: float = 1.0,
          memory_max_kb: int = MEMORY_MAX_KB, leave_out: list[str] | None = None) -> list[Outcome]:
    readers = all_readers(folder)
    calls = [(readers[trial % len(readers)], trial, seed, folder, keep, wait, memory_max_kb) for trial in range(trials)]
    calls = [call for call in calls if call[0].name not in (leave_out or [])]
    if processes == 1:
        return [one(*call) for call in calls]
    with ProcessPoolExecutor(processes) as pool:
        return list(pool.map(one, *zip(*calls), chunksize=20))


def report(outcomes: list[Outcome]) -> str:
    lines = ["reader                   trials  status 0    1    2    3  slowest s  most MB  faults"]
    by_reader = collections.defaultdict(list)
    for outcome in outcomes:
        by_reader[outcome.reader].append(outcome)
    for name, mine in by_reader.items():
        counts = collections.Counter(o.status for o in mine)
        lines.append(f"{name:<24} {len(mine):>6}  {counts[0]:>8} {counts[1]:>4} {counts[2]:>4} {counts[3]:>4}  {max(o.seconds for o in mine):>9.1f}"
                     f"  {max(o.memory_kb for o in mine) / 1000:>7.0f}  {sum(bool(o.fault) for o in mine):>6}")
    return "\n".join(lines + [f"{o.trial} {o.reader}: {o.fault}" for o in outcomes if o.fault])


def main() -> int:
    parser = argparse.ArgumentParser(description="Gives spoilt inputs to every reader of the program.")
    parser.add_argument("--trials", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for inputs that failed")
    parser.add_argument("--refusals", type=pathlib.Path, help="file for the forms of refusals, with their number of each reader")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--wait", type=float, default=1.0, help="times as long by the clock, on a busy machine")
    parser.add_argument("--memory-mb", type=int, default=MEMORY_MAX_KB // 1000, help="resident memory that a trial may take")
    parser.add_argument("--leave-out", action="append", default=[], metavar="READER", help="no trial of this reader")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        outcomes = drive(asked.trials, asked.seed, pathlib.Path(folder), asked.keep, asked.processes, asked.wait, asked.memory_mb * 1000,
                         asked.leave_out)
    print(report(outcomes))
    if asked.refusals:
        forms = collections.Counter((o.reader, o.refusal) for o in outcomes if o.refusal)
        asked.refusals.write_text("".join(f"{count:6} {reader:<24} {form}\n" for (reader, form), count in sorted(forms.items())))
    return 1 if any(outcome.fault for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
