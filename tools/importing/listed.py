"""Folders with a list of pictures and times: TUM's rgb.txt, and the ASL/EuRoC layout as it is found in the wild."""

import csv
import pathlib
from collections.abc import Iterator
from decimal import Decimal, InvalidOperation

from importing.calibration_files import read_lens
from importing.source import NS, Account, Frame, Options, Source

from judge.errors import BadInput

TUM_LISTS = ("rgb.txt", "gray.txt", "images.txt")


def tum_list(path: pathlib.Path) -> pathlib.Path | None:
    """TUM's list of a folder; None where there is none. COLMAP's images.txt has another form."""
    for name in TUM_LISTS:
        file = path / name
        if file.is_file() and not (path / "cameras.txt").exists():
            return file
    return None


def open_tum(path: pathlib.Path, options: Options) -> Source:
    account, rows = Account(), []
    listed = tum_list(path)
    for number, line in enumerate(listed.read_text(errors="replace").splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        parts = line.split()
        try:
            rows.append((int(Decimal(parts[0]) * NS), path / parts[1]))
        except (IndexError, InvalidOperation):
            raise BadInput(f"{listed}:{number}: '{line.strip()}' is not 'seconds file'") from None
    if not rows:
        raise BadInput(f"{listed}: lists no pictures")
    if (path / "groundtruth.txt").exists():
        account.assumed.append("groundtruth.txt is left out: it is the camera's path in a room, not a target's")
    return Source(f"TUM sequence of {len(rows)} pictures", _existing(rows, account), account, len(rows))


def camera_folder(path: pathlib.Path, camera: str) -> pathlib.Path | None:
    """The folder of a camera in the ASL layout, whichever of its levels was named; None where it is none."""
    for folder in (path / "mav0" / camera, path / camera, path):
        if (folder / "data.csv").is_file() or ((folder / "data").is_dir() and (folder / "sensor.yaml").is_file()):
            return folder
    return None


def open_euroc(path: pathlib.Path, options: Options) -> Source:
    folder, account = camera_folder(path, options.camera), Account()
    rows = _euroc_rows(folder, account)
    lens, lens_from = None, ""
    if (folder / "sensor.yaml").is_file():
        lens, lens_from = read_lens(folder / "sensor.yaml", options.camera), "sensor.yaml of the source"
    listed = {file.name for _, file in rows}
    beside = sum(file.name not in listed for file in (folder / "data").iterdir()) if (folder / "data").is_dir() else 0
    if beside:
        account.assumed.append(f"{beside} files in {folder / 'data'} are not in data.csv and are left out")
    return Source(f"ASL/EuRoC sequence, {folder.name}, {len(rows)} pictures", _existing(sorted(rows), account), account, len(rows), lens, lens_from)


def _euroc_rows(folder: pathlib.Path, account: Account) -> list[tuple[int, pathlib.Path]]:
    table = folder / "data.csv"
    if not table.is_file():
        account.assumed.append("data.csv is missing: times are those in the pictures' names")
        files = [file for file in (folder / "data").iterdir() if file.stem.isdigit()]
        return [(int(file.stem), file) for file in files]
    rows = []
    with open(table, newline="", errors="replace") as stream:
        for number, row in enumerate(csv.reader(stream, delimiter=","), 1):
            cells = [cell.strip() for cell in row]
            if not any(cells) or cells[0].startswith(("#", "\ufeff#", "timestamp")):
                continue
            try:
                time_ns = int(Decimal(cells[0]))
            except InvalidOperation:
                raise BadInput(f"{table}:{number}: '{cells[0]}' is not a time in nanoseconds") from None
            name = cells[1] if len(cells) > 1 and cells[1] else f"{cells[0]}.png"
            rows.append((time_ns, folder / "data" / name))
    if not rows:
        raise BadInput(f"{table}: lists no pictures")
    if any(b[0] < a[0] for a, b in zip(rows, rows[1:])):
        account.assumed.append("data.csv is not in order of time: sorted")
    return rows


def _existing(rows: list[tuple[int, pathlib.Path]], account: Account) -> Iterator[Frame]:
    for time_ns, file in rows:
        if not file.is_file():
            account.dropped["listed, but the file is missing"] += 1
            continue
        yield Frame(time_ns, file=file)
