"""faults.csv beside truth.csv: what was done on purpose to which frame of a sequence."""

import csv
import pathlib
from dataclasses import astuple, dataclass

LOG_FILE = "faults.csv"
LOG_COLUMNS = ("frame", "timestamp_ns", "kind", "detail")


@dataclass(frozen=True)
class LogEntry:
    """What was done to one frame of the source."""

    frame: int
    timestamp_ns: int
    kind: str
    detail: str


def write_log(path: pathlib.Path, log: list[LogEntry]) -> None:
    with open(path, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(LOG_COLUMNS)
        table.writerows(astuple(one) for one in log)


def read_log(path: pathlib.Path) -> list[LogEntry]:
    """The log beside truth.csv; empty where a sequence has none."""
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return [LogEntry(int(r["frame"]), int(r["timestamp_ns"]), r["kind"], r["detail"]) for r in csv.DictReader(file)]
