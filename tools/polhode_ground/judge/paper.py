"""The paper's own figures beside those of replays of its two cases, and the known length that gives their scale.

Call: paper.py scale SEQ            prints --set arguments, one a line, that give the replay the known length
      paper.py table 2D.json 3D.json  prints the tables from reports of hil/evaluate.py; '-' for one that is not there
"""

import json
import pathlib
import sys
from typing import Any

from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import read_json
from polhode_ground.common.tables import COUNTS
from polhode_ground.judge.report import UNKNOWN, lookup, table, text_of

# The paper's scale in its 2D case is the longer edge of a solar panel.
PREFERRED_LENGTH = "panel_long_edge"
# (title, the paper's figure, path into a motion report, format); RMSE and mean relative errors as the paper has them.
ROWS = {
    "2D": (
        ("2D linear velocity, mean relative error [%]", "5", "velocity.mean_error_percent", "{:.2f}"),
        ("   the same, with the origin moved to the mass centre", "", "velocity.mean_error_offset_corrected_percent", "{:.2f}"),
        ("2D angular velocity, mean relative error [%]", "2.3", "rates.mean_speed_error_percent", "{:.3f}"),
    ),
    "3D": (
        ("3D velocity RMSE [m/s]", "0.0002", "velocity.rmse_m_s", "{:.6f}"),
        ("   the same, with the origin moved to the mass centre", "", "velocity.rmse_offset_corrected_m_s", "{:.6f}"),
        ("   along the line of sight, as published", "", "velocity.rmse_z_m_s", "{:.6f}"),
        ("3D w_x RMSE [deg/s]", "0.0056", "rates.rmse_deg_s.x", "{:.5f}"),
        ("3D w_y RMSE [deg/s]", "0.0021", "rates.rmse_deg_s.y", "{:.5f}"),
        ("3D w_x period error [%]", "0.043", "rates.period.x.error_percent", "{:.4f}"),
        ("3D w_y period error [%]", "0.006", "rates.period.y.error_percent", "{:.4f}"),
    ),
}
COMMON = (
    ("frames with a pose [%]", "", "coverage.coverage", "percent"),
    ("attitude RMSE [deg]", "", "attitude.rmse_deg", "{:.3f}"),
    ("scale error [%]", "", "position.scale_error_percent", "{:+.2f}"),
    ("scale taken from the truth", "", "velocity.scale_from_alignment", "{}"),
    ("nearer to the truth or its twin", "", "twin.verdict", "{}"),
)


def scale_arguments(sequence: pathlib.Path) -> list[str]:
    """--set arguments for the known length that scene.json marks; [] where no length is seen well in any frame."""
    path = sequence / "scene.json"
    lengths = [one for one in read_json(path).get("known_lengths", []) if one.get("points_px")]
    if not lengths:
        return []
    chosen = next((one for one in lengths if one["name"] == PREFERRED_LENGTH), lengths[0])
    try:
        ends = ", ".join(f"[{u:.4f}, {v:.4f}]" for u, v in chosen["points_px"])
        return [
            "--set",
            f"scale.known_length_m={chosen['length_m']!r}",
            "--set",
            f"scale.points_px=[{ends}]",
            "--set",
            f"scale.frame_timestamp_ns={int(chosen['frame_timestamp_ns'])}",
        ]
    except (KeyError, TypeError, ValueError) as problem:
        raise BadInput(f"{path}: known_lengths: {problem!r}") from None


def paper_table(reports: dict[str, dict[str, Any]]) -> str:
    """Rows of both cases; reports maps '2D' and '3D' to one run's report, or lacks them."""
    rows = []
    for case, case_rows in ROWS.items():
        report = reports.get(case)
        if report is None:
            continue
        for title, paper, path, layout in (*case_rows, *((f"{case} {t}", p, q, f) for t, p, q, f in COMMON)):
            ours = [text_of(lookup(report, f"motion.{kind}.{path}"), layout) for kind in ("causal", "smoothed")]
            rows.append([title, paper or UNKNOWN, *ours])
    return table(["", "paper", "ours causal", "ours smoothed"], rows)


def counts_table(reports: dict[str, dict[str, Any]]) -> str:
    """Points and features over time of both cases, as the causal run told them; means over the parts of a run."""
    rows = []
    for case, report in reports.items():
        for part in lookup(report, "motion.causal.counts") or []:
            rows.append([f"{case} {part['from_s']:.0f} to {part['to_s']:.0f} s", *(text_of(part[name], "{:.0f}") for name in COUNTS)])
    return table(["", "features", "matches", "inliers", "points in the map", "keyframes"], rows)


def main() -> int:
    if len(sys.argv) == 3 and sys.argv[1] == "scale":
        print("\n".join(scale_arguments(pathlib.Path(sys.argv[2]))))
        return 0
    if len(sys.argv) == 4 and sys.argv[1] == "table":
        reports = {
            case: json.loads(pathlib.Path(path).read_text())["runs"][0] for case, path in zip(("2D", "3D"), sys.argv[2:]) if path != "-"
        }
        print(f"{paper_table(reports)}\n\nPoints and features over time, means over tenths of the run:\n{counts_table(reports)}")
        return 0
    raise BadInput("usage: paper.py scale SEQ | table 2D.json 3D.json")


if __name__ == "__main__":
    from polhode_ground.common.venv import run_main

    run_main(main, "paper")
