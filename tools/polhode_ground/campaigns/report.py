"""The report of a campaign: one page that needs no other file, its tables as CSV and Parquet beside it."""

import csv
import json
import pathlib
from collections.abc import Callable, Sequence
from typing import Any

import jinja2

from polhode_ground.campaigns import figures, results, summaries
from polhode_ground.campaigns.execution import FAILURES_FILE, SESSIONS_FILE
from polhode_ground.common.errors import BadInput
from polhode_ground.common.whole_file import beside, write_whole

TEMPLATE = "report.html.jinja"
WORST = 10
FOLDER = "report"
SUMMARY_COLUMNS = ("transform", "setting", "measure", "count", "of", "centre", "low", "high", "p90", "worst")
PAIRED_COLUMNS = ("transform", "setting", "measure", "pairs", "mean", "low", "high", "better", "worse", "probability")


def _groups(rows: list[dict[str, Any]]) -> dict[tuple[str, str], list[dict[str, Any]]]:
    """Rows by (transform, setting), in order of appearance."""
    found: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        found.setdefault((row["transform"], row["setting"]), []).append(row)
    return found


def _name(group: tuple[str, str]) -> str:
    transform, setting = group
    return setting if transform == "plain" else f"{transform}, {setting}"


# {(transform, setting): {a measure's title: its summary, None where no run has a value}}
Summaries = dict[tuple[str, str], dict[str, dict[str, Any] | None]]


def summarised(rows: list[dict[str, Any]]) -> Summaries:
    """Every measure of every group, from which all tables are made: the bootstrap is what takes the time."""
    return {
        group: {measure.title: summaries.summary(members, measure) for measure in summaries.MEASURES}
        for group, members in _groups(rows).items()
    }


def summary_table(found: Summaries) -> list[dict[str, Any]]:
    """One row for each group and measure that has a value."""
    return [
        {"transform": transform, "setting": setting, "measure": title, **summary}
        for (transform, setting), by_title in found.items()
        for title, summary in by_title.items()
        if summary is not None
    ]


def paired_table(base: list[dict[str, Any]], new: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row for each group and measure over the runs that both campaigns have."""
    table = []
    both = summaries.pairs(base, new)
    for (transform, setting), members in _groups([row for _, row in both]).items():
        olds = [old for old, row in both if (row["transform"], row["setting"]) == (transform, setting)]
        for measure in summaries.MEASURES:
            found = summaries.paired(olds, members, measure)
            if found is not None:
                table.append({"transform": transform, "setting": setting, "measure": measure.title, **found})
    return table


def _text(value: float | None, layout: str = "{:.3g}") -> str:
    if value is None:
        return "-"
    return "never" if value == summaries.NEVER else layout.format(value)


def _cell(found: dict[str, Any] | None, measure: summaries.Measure) -> str:
    if found is None:
        return "-"
    text = {name: _text(found[name], measure.layout) for name in ("centre", "low", "high", "p90", "worst")}
    cell = f"<b>{text['centre']}</b>" + ("" if found["low"] is None else f" [{text['low']}, {text['high']}]")
    if measure.how == "median":
        cell += f"<br><small>{text['p90']} | {text['worst']}</small>"
    return cell + (f"<br><small>of {found['count']}</small>" if found["count"] < found["of"] else "")


def _table(found: Summaries, cell_of: Callable[[dict[str, Any] | None, summaries.Measure], str]) -> list[list[str]]:
    """A row for each measure that some group has, by cell_of(summary, measure)."""
    rows = [[measure.title, *(cell_of(by_title[measure.title], measure) for by_title in found.values())] for measure in summaries.MEASURES]
    return [row for row in rows if any(cell != "-" for cell in row[1:])]


def _turn_table(groups: dict[str, Any]) -> list[list[str]]:
    rows = []
    for turn in summaries.TURNS_DEG:
        shares = [summaries.share_by_turn(members, turn) for members in groups.values()]
        rows.append([f"{turn} deg", *("-" if share is None else f"{100 * share:.0f} %" for share in shares)])
    return rows


def _paired_html(table: list[dict[str, Any]]) -> list[list[str]]:
    by_title = {measure.title: measure for measure in summaries.MEASURES}
    rows = []
    for one in table:
        layout = by_title[one["measure"]].layout.replace("{:", "{:+")
        interval = (
            "-"
            if one["mean"] is None
            else (
                f"<b>{_text(one['mean'], layout)}</b>"
                + ("" if one["low"] is None else f" [{_text(one['low'], layout)}, {_text(one['high'], layout)}]")
            )
        )
        rows.append(
            [
                _name((one["transform"], one["setting"])),
                one["measure"],
                str(one["pairs"]),
                interval,
                _text(one["better"], "{}"),
                _text(one["worse"], "{}"),
                _text(one["probability"], "{:.2g}"),
            ]
        )
    return rows


def _worst(out: pathlib.Path, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The worst runs with their pictures, drawn once."""
    found = []
    for row in sorted(rows, key=summaries.badness)[:WORST]:
        pictures = figures.of_run(row, out / FOLDER / "pictures" / row["result"])
        found.append({"row": row, "pictures": [(path.stem, path.relative_to(out / FOLDER)) for path in pictures]})
    return found


def _sessions(out: pathlib.Path) -> list[dict[str, Any]]:
    path = out / SESSIONS_FILE
    sessions = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    for session in sessions:
        session["share"] = session["wall_s"] / max(session["task_wall_s"], 1e-9)
        session["text"] = ", ".join(f"{count} {kind}" for kind, count in session["tasks"].items())
    return sessions


def _write_csv(path: pathlib.Path, columns: Sequence[str], table: list[dict[str, Any]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with beside(path, ours=True) as part, open(part, "w", newline="") as stream:
        writer = csv.DictWriter(stream, columns, lineterminator="\n", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(table)


def write_report(out: pathlib.Path, vs: pathlib.Path | None = None, pictures: bool = True) -> tuple[pathlib.Path, str]:
    """Writes OUT/report from what is done so far. @param vs  another campaign's folder, the base of paired differences.

    @return the page, and its figures as text for the terminal.
    """
    book, rows = results.rows_so_far(out)
    base = results.rows_so_far(vs) if vs is not None else None
    if base is not None and not summaries.pairs(base[1], rows):
        raise BadInput(f"--vs {vs}: has no run of a sequence and setting of {out}")
    folder = out / FOLDER
    results.write_tables(out, folder, rows)
    groups = {_name(key): members for key, members in _groups(rows).items()}
    found, base_found = summarised(rows), summarised(base[1]) if base else {}
    differences = paired_table(base[1], rows) if base else []
    _write_csv(folder / "summary.csv", SUMMARY_COLUMNS, summary_table(found))
    (folder / "paired.csv").unlink(missing_ok=True)
    if base:
        _write_csv(folder / "paired.csv", PAIRED_COLUMNS, differences)
    if rows:
        write_whole(folder / "summary.md", markdown(found, rows), ours=True)
    failures = out / FAILURES_FILE
    page = (
        jinja2.Environment(
            loader=jinja2.FileSystemLoader(pathlib.Path(__file__).parent),
            trim_blocks=True,
            lstrip_blocks=True,
            autoescape=True,
            undefined=jinja2.StrictUndefined,
        )
        .get_template(TEMPLATE)
        .render(
            book=book,
            done=len(rows),
            names=list(groups),
            main=_table(found, _cell),
            turns=_turn_table(groups) if rows else [],
            base=base[0] if base else None,
            other_judge=base is not None and base[0].get("judge_key") != book.get("judge_key"),
            unpaired=len(rows) - len(summaries.pairs(base[1], rows)) if base else 0,
            base_main=_table(base_found, _cell),
            base_groups=[_name(key) for key in base_found],
            paired=_paired_html(differences),
            figures=[figures.first_pose(groups), figures.distributions(groups)] if rows else [],
            worst=_worst(out, rows) if pictures else [],
            sessions=_sessions(out),
            base_sessions=_sessions(vs) if vs else [],
            failures=json.loads(failures.read_text()) if failures.exists() else [],
            rows=rows,
            text=_text,
        )
    )
    write_whole(folder / "index.html", page, ours=True)
    return folder / "index.html", printed(found)


def _plain_cell(found: dict[str, Any] | None, measure: summaries.Measure) -> str:
    if found is None:
        return "-"
    text = {name: _text(found[name], measure.layout) for name in ("centre", "low", "high")}
    return text["centre"] if found["low"] is None else f"{text['centre']} [{text['low']}, {text['high']}]"


def _header(found: Summaries) -> list[str]:
    return ["", *(_name(group) for group in found)]


def printed(found: Summaries) -> str:
    """The figures for the terminal."""
    from polhode_ground.judge.report import table

    lines = _table(found, _plain_cell)
    return table(_header(found), lines) if lines else "no run is judged yet"


def markdown(found: Summaries, rows: list[dict[str, Any]]) -> str:
    """The figures and the curve of the first pose as Markdown tables, for a document."""
    header, lines = _header(found), _table(found, _plain_cell)
    turns = [
        [f"first pose within {row[0]} of turn", *row[1:]]
        for row in _turn_table({_name(key): members for key, members in _groups(rows).items()})
    ]
    return "\n".join(f"| {' | '.join(line)} |" for line in [header, ["---"] * len(header), *lines, *turns]) + "\n"
