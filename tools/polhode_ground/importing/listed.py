"""Folders with a list of pictures and times: TUM's rgb.txt, and the ASL/EuRoC layout as it is found in the wild."""

import pathlib
import unicodedata
from collections import defaultdict
from collections.abc import Iterator

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.calibration_files import read_lens
from polhode_ground.importing.calibration_text import yaml_values
from polhode_ground.importing.picture_list import in_ns, read_list
from polhode_ground.importing.row_times import row_time_of
from polhode_ground.importing.source import Account, Frame, Options, Source, lens_if_any

OTHER_LETTERS = "the list has names in other letters than the files have"
TUM_LISTS = ("rgb.txt", "gray.txt", "images.txt")


def tum_list(path: pathlib.Path) -> pathlib.Path | None:
    """TUM's list of a folder; None where there is none. COLMAP's images.txt has another form."""
    for name in TUM_LISTS:
        file = path / name
        if file.is_file() and not (path / "cameras.txt").exists():
            return file
    return None


def open_tum(path: pathlib.Path, options: Options) -> Source:
    account, listed = Account(), tum_list(path)
    rows = _timed(listed, path, "'seconds file'", "s", options, account)
    if (path / "groundtruth.txt").exists():
        account.assumed.append("groundtruth.txt is left out: it is the camera's path in a room, not a target's")
    return Source(f"TUM sequence of {len(rows)} pictures", _existing(rows, account), account, [time for time, _ in rows], len(rows))


def _timed(
    table: pathlib.Path, folder: pathlib.Path, wanted: str, unit: str, options: Options, account: Account
) -> list[tuple[int, pathlib.Path]]:
    """(time, file) of a list's rows. @param unit  that such lists have where they tell none"""
    listed = read_list(table, wanted)
    times = in_ns([time for time, _ in listed.rows], listed.unit or unit, options.stamp_unit, str(table), account, options.rate_hz)
    files = _Present(account)
    return [(time, files.found(folder, name)) for time, (_, name) in zip(times, listed.rows)]


class _Present:
    """Finds files by names that another system wrote: its separators, accents as letters of their own, its small and large letters."""

    def __init__(self, account: Account) -> None:
        self.account = account
        self.by_plain_name: dict[pathlib.Path, dict[str, list[pathlib.Path]]] = {}  # of folders

    def found(self, folder: pathlib.Path, name: str) -> pathlib.Path:
        """The name as it is written where no one file is meant by it."""
        written, as_windows = folder / name, folder / pathlib.PureWindowsPath(name).as_posix()
        if written.is_file() or as_windows.is_file():
            return written if written.is_file() else as_windows
        if as_windows.parent not in self.by_plain_name:
            files = as_windows.parent.iterdir() if as_windows.parent.is_dir() else ()
            self.by_plain_name[as_windows.parent] = defaultdict(list)
            for file in files:
                self.by_plain_name[as_windows.parent][_plain(file.name)].append(file)
        meant = self.by_plain_name[as_windows.parent].get(_plain(as_windows.name), [])
        if len(meant) != 1:
            return written
        if not any(sentence.startswith(OTHER_LETTERS) for sentence in self.account.assumed):
            self.account.note(
                f"{OTHER_LETTERS}, as {name}: the one file that differs in small and large letters or in how accents are written is taken, {meant[0].name}"
            )
        return meant[0]


def _plain(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()


def camera_folder(path: pathlib.Path, camera: str) -> pathlib.Path | None:
    """The folder of a camera in the ASL layout, whichever of its levels was named; None where it is none."""
    for folder in (path / "mav0" / camera, path / camera, path):
        if (folder / "data.csv").is_file() or ((folder / "data").is_dir() and (folder / "sensor.yaml").is_file()):
            return folder
    return None


def open_euroc(path: pathlib.Path, options: Options) -> Source:
    folder, account = camera_folder(path, options.camera), Account()
    rows = _euroc_rows(folder, options, account)
    lens, lens_from, line_time_ns = None, "", 0.0
    if (folder / "sensor.yaml").is_file():
        line_time_ns = _row_time(folder / "sensor.yaml", account)
        lens, lens_from = lens_if_any(lambda: (read_lens(folder / "sensor.yaml", options.camera), "sensor.yaml of the source"), account)
    listed = {file.name for _, file in rows}
    beside = sum(file.name not in listed for file in (folder / "data").iterdir()) if (folder / "data").is_dir() else 0
    if beside:
        account.assumed.append(f"{beside} files in {folder / 'data'} are not in data.csv and are left out")
    return Source(
        f"ASL/EuRoC sequence, {folder.name}, {len(rows)} pictures",
        _existing(rows, account),
        account,
        [time for time, _ in rows],
        len(rows),
        lens,
        lens_from,
        beside=_beside(folder, account),
        line_time_ns=line_time_ns,
    )


def _row_time(sensor: pathlib.Path, account: Account) -> float:
    try:
        time_ns, said = row_time_of(yaml_values(sensor), str(sensor))
    except BadInput as problem:
        time_ns, said = 0.0, f"{problem}: times of its rows are not known"
    account.note(said)
    return time_ns


def _beside(folder: pathlib.Path, account: Account) -> tuple[pathlib.Path, ...]:
    """The truth and the model of a sequence of this layout's own; what EuRoC has beside the pictures is told."""
    account.assumed += [
        f"{file.parent.name} is left out: it is the path of the camera's carrier in a room, not a target's"
        for file in sorted(folder.parent.glob("state_groundtruth*/data.csv"))
    ]
    root = folder.parent.parent if folder.parent.name == "mav0" else folder.parent
    return tuple(root / name for name in ("truth.csv", "model.ply") if folder.name == "cam0" and (root / name).is_file())


def _euroc_rows(folder: pathlib.Path, options: Options, account: Account) -> list[tuple[int, pathlib.Path]]:
    table = folder / "data.csv"
    if not table.is_file():
        account.assumed.append("data.csv is missing: times are those in the pictures' names")
        files = sorted((int(file.stem), file) for file in (folder / "data").iterdir() if file.stem.isdecimal())
        if not files:
            raise BadInput(f"{folder}: no data.csv, and in data no pictures whose names are times")
        return list(
            zip(
                in_ns([time for time, _ in files], "ns", options.stamp_unit, str(folder / "data"), account, options.rate_hz),
                [file for _, file in files],
            )
        )
    rows = _timed(table, folder / "data", "a time in nanoseconds and a name", "ns", options, account)
    return [(time, _found(file, folder)) for time, file in rows]


def _found(file: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """Some lists write the folder, too, or Windows' separators."""
    name = pathlib.PureWindowsPath(str(file)).name.split(" #")[0].rstrip()
    return file if file.is_file() or not (folder / "data" / name).is_file() else folder / "data" / name


def _existing(rows: list[tuple[int, pathlib.Path]], account: Account) -> Iterator[Frame]:
    missing = [file for _, file in rows if not file.is_file()]
    reason = f"listed, but the file is missing: {missing[0]}{' is the first' if len(missing) > 1 else ''}" if missing else ""
    for time_ns, file in rows:
        if not file.is_file():
            account.dropped[reason] += 1
            continue
        yield Frame(time_ns, file=file)
