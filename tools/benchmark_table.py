#!/usr/bin/env python3
"""The cost of a replay from its summary.json, as a table.

    tools/benchmark_table.py SUMMARY.json
"""

import json
import sys


def rows(timings: dict) -> list[tuple[str, ...]]:
    """One line a span, in milliseconds; spans that never ran are left out. By the clock, and in processor time of the stepping
    thread where that was measured."""
    keys = [clock + key for clock in ("", "cpu_") for key in ("p50_us", "p95_us", "p99_us", "max_us")]
    table = [("", "calls", "p50 ms", "p95 ms", "p99 ms", "max ms", "cpu p50", "cpu p95", "cpu p99", "cpu max")]
    for name, span in timings.items():
        if span["count"]:
            table.append((name, str(span["count"]), *(f"{span[key] / 1000:.2f}" if key in span else "" for key in keys)))
    return table


def main() -> None:
    with open(sys.argv[1]) as file:
        summary = json.load(file)
    for row in rows(summary["timings"]):
        print(f"{row[0]:<10}" + "".join(f"{cell:>10}" for cell in row[1:]))
    cost = summary["cost"]
    print(f"{cost['frames_per_s']:.1f} frames/s, {1000 * cost['cpu_per_frame_s']:.1f} ms of processor time a frame, "
          f"{summary['memory']['peak_resident_octets'] / 1e6:.0f} MB resident at most")


if __name__ == "__main__":
    main()
