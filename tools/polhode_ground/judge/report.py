"""The judge's table: one row per quantity, one column per run and motion file."""

import math
from typing import Any

# (title, path into a motion file's report, format)
MOTION_ROWS = (
    ("coverage [%]", "coverage.coverage", "percent"),
    ("coverage from the first pose on [%]", "coverage.coverage_after_first_pose", "percent"),
    ("frames until the first pose", "coverage.frames_until_first_pose", "{:d}"),
    ("poses judged", "target_frames.poses_judged", "{:d}"),
    ("attitude RMSE [deg]", "attitude.rmse_deg", "{:.3f}"),
    ("attitude maximum [deg]", "attitude.max_deg", "{:.3f}"),
    ("position RMSE [% of range]", "position.rmse_percent_of_range", "{:.3f}"),
    ("target seen from camera RMSE [% of range]", "position.rmse_from_camera_percent_of_range", "{:.3f}"),
    ("position RMSE, own scale [m]", "position.rmse_m", "{:.4g}"),
    ("scale error [%]", "position.scale_error_percent", "{:+.2f}"),
    ("w_x RMSE [deg/s]", "rates.rmse_deg_s.x", "{:.4f}"),
    ("w_y RMSE [deg/s]", "rates.rmse_deg_s.y", "{:.4f}"),
    ("w_z RMSE [deg/s]", "rates.rmse_deg_s.z", "{:.4f}"),
    ("mean angular speed error [%]", "rates.mean_speed_error_percent", "{:.3f}"),
    ("period error w_x [%]", "rates.period.x.error_percent", "{:.4f}"),
    ("period error w_y [%]", "rates.period.y.error_percent", "{:.4f}"),
    ("period error w_z [%]", "rates.period.z.error_percent", "{:.4f}"),
    ("velocity RMSE [m/s]", "velocity.rmse_m_s", "{:.3g}"),
    ("velocity RMSE, origin moved [m/s]", "velocity.rmse_offset_corrected_m_s", "{:.3g}"),
    ("mean velocity error [%]", "velocity.mean_error_percent", "{:.2f}"),
    ("mean velocity error, origin moved [%]", "velocity.mean_error_offset_corrected_percent", "{:.2f}"),
    ("attitude within its 95 % bound [%]", "consistency.attitude.within_95_percent_bound", "percent"),
    ("position within its 95 % bound [%]", "consistency.position.within_95_percent_bound", "percent"),
    ("velocity within its 95 % bound [%]", "consistency.velocity.within_95_percent_bound", "percent"),
    ("rate within its 95 % bound [%]", "consistency.rate.within_95_percent_bound", "percent"),
    ("nearer to the truth or its twin", "twin.verdict", "{}"),
    ("target frames T", "target_frames.count", "{:d}"),
    ("in-plane rate factor (+1 true, -1 twin)", "twin.in_plane_rate_factor", "{:+.2f}"),
)
SHAPE_ROWS = (
    ("cloud points", "shape.points", "{:d}"),
    ("cloud to mesh RMSE [% of size]", "shape.distance_rmse_percent", "{:.2f}"),
    ("cloud to mesh median [% of size]", "shape.distance_median_percent", "{:.2f}"),
    ("seen surface within 2 % of size [%]", "shape.complete_seen_within_2_percent", "percent"),
    ("seen surface within 5 % of size [%]", "shape.complete_seen_within_5_percent", "percent"),
)
BODY_ROWS = (
    ("planes found", "body.planes_found", "{:d}"),
    ("planes that the mesh does not have", "body.planes_made_up", "{:d}"),
    ("plane normal error, median [deg]", "body.plane_angle_median_deg", "{:.2f}"),
    ("plane normal error, maximum [deg]", "body.plane_angle_max_deg", "{:.2f}"),
    ("cylinder axis error [deg]", "body.cylinder.axis_error_deg", "{:.2f}"),
    ("cylinder radius error [%]", "body.cylinder.radius_error_percent", "{:+.2f}"),
    ("centroid error [% of size]", "body.centroid.error_percent", "{:.2f}"),
    ("centroid error before completion [% of size]", "body.centroid.error_before_completion_percent", "{:.2f}"),
    ("hull volume error [%]", "body.surface.volume_error_percent", "{:+.1f}"),
    ("hull to true hull RMSE [% of size]", "body.surface.distance_rmse_percent", "{:.2f}"),
    ("measured faces to mesh RMSE [% of size]", "body.faces.measured_rmse_percent", "{:.2f}"),
    ("seen surface to faces RMSE [% of size]", "body.faces.seen_rmse_percent", "{:.2f}"),
)
DYNAMICS_ROWS = (
    ("inertia ratio, middle over least, error [%]", "dynamics.inertia_ratios.middle_over_least.error_percent", "{:+.2f}"),
    ("   in its sigmas", "dynamics.inertia_ratios.middle_over_least.sigmas_off", "{:.1f}"),
    ("inertia ratio, largest over least, error [%]", "dynamics.inertia_ratios.largest_over_least.error_percent", "{:+.2f}"),
    ("   in its sigmas", "dynamics.inertia_ratios.largest_over_least.sigmas_off", "{:.1f}"),
    ("principal axes, worst error [deg]", "dynamics.principal_axes_worst_deg", "{:.2f}"),
    ("centre of mass, axes that are known", "dynamics.centre_of_mass.axes_known", "{:d}"),
    ("centre of mass error [m]", "dynamics.centre_of_mass.error_m", "{:.4g}"),
    ("centre of mass, worst axis [m]", "dynamics.centre_of_mass.worst_axis_m", "{:.4g}"),
)
COST_ROWS = (
    ("CPU per frame [ms]", "cost.cpu_per_frame_ms", "{:.2f}"),
    ("CPU per frame with the end's work [ms]", "cost.cpu_total_per_frame_ms", "{:.2f}"),
    ("wall per frame [ms]", "cost.wall_per_frame_ms", "{:.2f}"),
    ("step p50 [ms]", "cost.step_p50_ms", "{:.2f}"),
    ("step p99 [ms]", "cost.step_p99_ms", "{:.2f}"),
    ("step maximum [ms]", "cost.step_max_ms", "{:.2f}"),
    ("peak resident memory [MB]", "cost.peak_resident_mb", "{:.1f}"),
)
UNKNOWN = "-"


def lookup(report: dict[str, Any] | None, path: str) -> Any:
    """Value at 'a.b.c', None where any part is missing."""
    value = report
    for key in path.split("."):
        if not isinstance(value, dict) or value.get(key) is None:
            return None
        value = value[key]
    return value


def text_of(value: Any, layout: str) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return UNKNOWN
    return f"{100 * value:.1f}" if layout == "percent" else layout.format(value)


def table(header: list[str], rows: list[list[str]]) -> str:
    """Columns padded to their widest cell, the first to the left, the rest to the right."""
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    lines = [
        "  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))) for row in [header, *rows]
    ]
    lines.insert(1, "  ".join("-" * w for w in widths))
    return "\n".join(line.rstrip() for line in lines)


def _labels(reports: list[dict[str, Any]]) -> list[str]:
    """Short names of the runs: the last folder, with its parent where two are called the same, with a number if need be."""
    parts = [report["run"].rstrip("/").split("/") for report in reports]
    names = [part[-1] for part in parts]
    names = [name if names.count(name) == 1 else "/".join(part[-2:]) for name, part in zip(names, parts)]
    return [name if names.count(name) == 1 else f"{name}#{i + 1}" for i, name in enumerate(names)]


def _body(title: str, cells: list[str]) -> list[list[str]]:
    return [[title, *cells]] if any(cell != UNKNOWN for cell in cells) else []


def motion_table(reports: list[dict[str, Any]]) -> str:
    columns = [
        (f"{label} {kind}", report["motion"][kind], report) for label, report in zip(_labels(reports), reports) for kind in report["motion"]
    ]
    rows = []
    for title, path, layout in MOTION_ROWS:
        rows += _body(title, [text_of(lookup(motion, path), layout) for _, motion, _ in columns])
    for title, path, layout in (*SHAPE_ROWS, *BODY_ROWS, *DYNAMICS_ROWS, *COST_ROWS):
        rows += _body(title, [text_of(lookup(report, path), layout) for _, _, report in columns])
    return table(["", *(name for name, _, _ in columns)], rows)


def notes(reports: list[dict[str, Any]]) -> list[str]:
    """Sentences that a reader must not miss."""
    remarks = dict.fromkeys(report.get("truth") for report in reports)
    lines = [f"truth: {remark}" for remark in remarks if remark]
    digests: dict[str, list[str]] = {}
    for label, report in zip(_labels(reports), reports):
        for kind, motion in report["motion"].items():
            who = f"{label} {kind}"
            if lookup(motion, "attitude.rmse_deg") is None:
                lines.append(f"{who}: fewer than two frames with a pose, nothing to align")
                continue
            twin = motion["twin"]
            if twin["verdict"] == "twin":
                lines.append(
                    f"{who}: DEPTH-REVERSED TWIN: {twin['rmse_to_twin_deg']:.2f} deg from the mirror image, "
                    f"{twin['rmse_to_truth_deg']:.2f} deg from the truth"
                )
            elif twin["verdict"] == "neither":
                lines.append(
                    f"{who}: follows neither the truth ({twin['rmse_to_truth_deg']:.1f} deg) "
                    f"nor its depth-reversed twin ({twin['rmse_to_twin_deg']:.1f} deg)"
                )
            frames = motion["target_frames"]
            if frames["poses_not_judged"]:
                lines.append(
                    f"{who}: {frames['poses_judged']} of {frames['poses_judged'] + frames['poses_not_judged']} poses are judged, the others have no truth "
                    "or stand alone in their target frame T"
                )
            if frames["count"] > 1:
                each = ", ".join(
                    f"T{one['target_frame']}: {one['frames']} frames, {one['attitude_rmse_deg']:.3f} deg" for one in frames["each"]
                )
                lines.append(f"{who}: poses are in {frames['count']} target frames T, each aligned by itself ({each})")
            if lookup(motion, "velocity.scale_from_alignment"):
                lines.append(f"{who}: scale unknown, velocity judged with the scale of the alignment")
        stated = report["determinism"]
        if stated:
            digests.setdefault(stated["bus_sha256"], []).append(label)
            if stated["summary_agrees"] is False:
                lines.append(f"{label}: bus.ccsds is NOT the file that summary.json names by its SHA-256")
    for digest, labels in digests.items():
        same = " (the same bytes)" if len(labels) > 1 else ""
        lines.append(f"bus.ccsds {digest[:16]}...: {', '.join(labels)}{same}")
    return lines


def prediction_table(judged: list[dict[str, Any]] | None) -> str:
    """Errors over the horizon; empty where the truth ends with the run."""
    rows = [
        [
            f"{row['ahead_s']:.0f}",
            f"{row['attitude_deg']:.3f}",
            f"{row['sigma_attitude_deg']:.3f}",
            f"{row['rate_deg_s']:.5f}",
            text_of(row["position_percent_of_range"], "{:.3f}"),
        ]
        for row in judged or []
        if row["ahead_s"] > 0
    ]
    header = ["predicted ahead [s]", "attitude error [deg]", "its sigma [deg]", "rate error [deg/s]", "position error [% of range]"]
    return table(header, rows) if rows else ""


def text_report(reports: list[dict[str, Any]]) -> str:
    """The whole report as printed."""
    parts = [
        f"sequence {reports[0]['sequence']}",
        motion_table(reports),
        *(prediction_table(report.get("prediction")) for report in reports),
        "\n".join(notes(reports)),
    ]
    return "\n\n".join(part for part in parts if part)
