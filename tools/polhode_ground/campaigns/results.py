"""The campaign's two tables: runs.parquet, one row a run, and frames.parquet, one row a frame; from what is done so far.

Columns that begin with cost_ are times and memory; all others are the same whenever and however the campaign was run.
"""

import json
import pathlib
from typing import Any

import pyarrow
import pyarrow.parquet

from polhode_ground.campaigns.book import read_book
from polhode_ground.campaigns.store import Store, is_whole

COST = "cost_"
POINT = "point_"  # where in the scene space a draw lies
RUNS_FILE, FRAMES_FILE = "runs.parquet", "frames.parquet"


def _names(entry: dict[str, Any]) -> dict[str, Any]:
    return {key: entry[key] for key in ("scene", "transform", "setting")}


def _against_limit(row: dict[str, Any], limit: dict[str, Any]) -> dict[str, Any]:
    """How late the first pose is; nothing where the images never decide. A run without a pose is as late as can be."""
    frame = limit["frame"]
    columns = {"decidable": frame is not None, "limit_frame": frame, "limit_turn_deg": limit["turn_deg"]}
    if frame is None:
        return columns
    late = float(row["first_pose_frame"] - frame) if row["acquired"] else float("inf")
    return columns | {"first_pose_after_limit_frames": late, "acquired_of_decidable": row["acquired"]}


def _row(entry: dict[str, Any], point: dict[str, Any], store: Store) -> dict[str, Any]:
    row: dict[str, Any] = _names(entry) | json.loads((store.result(entry["result"]) / "run.json").read_text())
    row |= {f"{POINT}{name}": value for name, value in point.items()}
    time = store.time(entry["time"]) if entry["time"] else None
    if time is not None and is_whole(time):
        row |= {f"{COST}{name}": value for name, value in json.loads((time / "time.json").read_text()).items()}
    limit = store.limit(entry["limit"]) if entry.get("limit") else None
    if limit is not None and is_whole(limit):
        row |= _against_limit(row, json.loads((limit / "limit.json").read_text()))
    return row | {
        "run_folder": entry["run"],
        "sequence_folder": entry["sequence"],
        "result": entry["result"],
        "sequence_key": entry["sequence_key"],
    }


def rows_so_far(out: pathlib.Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """(book, rows of the runs that are judged, in the book's order)."""
    book = read_book(out)
    store = Store(out, pathlib.Path(book["cache"]))
    points = {f"draw_{number:03d}": point for number, point in enumerate(book["draws"])}
    done = [entry for entry in book["runs"] if is_whole(store.result(entry["result"]))]
    return book, [_row(entry, points.get(entry["scene"], {}), store) for entry in done]


def write_tables(out: pathlib.Path, folder: pathlib.Path, rows: list[dict[str, Any]]) -> None:
    """runs.parquet and frames.parquet into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    if not rows:
        return
    names = list(dict.fromkeys(name for row in rows for name in row))
    table = pyarrow.Table.from_pylist([{name: row.get(name) for name in names} for row in rows])
    pyarrow.parquet.write_table(table, folder / RUNS_FILE)
    parts = []
    for row in rows:
        part = pyarrow.parquet.read_table(out / "results" / row["result"] / FRAMES_FILE)
        for place, name in enumerate(("scene", "transform", "setting")):
            part = part.add_column(place, name, pyarrow.array([row[name]] * len(part)))
        parts.append(part)
    pyarrow.parquet.write_table(pyarrow.concat_tables(parts, promote_options="permissive"), folder / FRAMES_FILE)
