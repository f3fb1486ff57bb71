"""The cost of a replay from its summary.json, as a table."""

import argparse
import json
import pathlib

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import run_main

EXAMPLE = "    tools/benchmark_table.py SUMMARY.json"


def rows(timings: dict) -> list[tuple[str, ...]]:
    """One line a span, in milliseconds; spans that never ran are left out. By the clock, and in processor time of the stepping
    thread where that was measured."""
    keys = [clock + key for clock in ("", "cpu_") for key in ("p50_us", "p95_us", "p99_us", "max_us")]
    table = [("", "calls", "p50 ms", "p95 ms", "p99 ms", "max ms", "cpu p50", "cpu p95", "cpu p99", "cpu max")]
    for name, span in timings.items():
        if span["count"]:
            table.append((name, str(span["count"]), *(f"{span[key] / 1000:.2f}" if key in span else "" for key in keys)))
    return table


def text_of(summary: dict) -> str:
    lines = [f"{row[0]:<10}" + "".join(f"{cell:>10}" for cell in row[1:]) for row in rows(summary["timings"])]
    cost = summary["cost"]
    lines.append(
        f"{cost['frames_per_s']:.1f} frames/s, {1000 * cost['cpu_per_frame_s']:.1f} ms of processor time a frame, "
        f"{summary['memory']['peak_resident_octets'] / 1e6:.0f} MB resident at most"
    )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=f"{__doc__}\n\n{EXAMPLE}", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("summary", metavar="SUMMARY.json", type=pathlib.Path, help="of a replay's output folder")
    file = parser.parse_args().summary
    try:
        text = text_of(json.loads(file.read_text()))
    except OSError as problem:
        raise BadInput(f"{file}: {problem.strerror}") from None
    except (ValueError, KeyError, TypeError) as problem:
        raise BadInput(f"{file}: not a replay's summary.json ({problem})") from None
    print(text)
    return 0


def command() -> None:
    run_main(main, "benchmark_table")
