"""A file of times beside a folder's pictures, one a picture in their order: KITTI's and DSO's times.txt, those of laboratories."""

import pathlib

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.picture_list import has_columns, in_ns, read_times
from polhode_ground.importing.source import Account, Options

TABLES = (".csv", ".tsv")  # of any name, where a head says that they have times and pictures' names
NAMES = ("times.txt", "timestamps.txt", "timestamp.txt", "times.csv", "timestamps.csv", "time.txt", "time.csv")


def times_beside(folder: pathlib.Path, files: list[pathlib.Path], options: Options, account: Account) -> list[int] | None:
    """In the folder, or beside it; None where none belongs to the pictures, which is told."""
    named = [path for path in (place / name for place in (folder, folder.parent) for name in NAMES) if path.is_file()]
    tables = sorted(path for path in folder.iterdir() if path.suffix.lower() in TABLES and path not in named)
    for path in [*named, *tables]:
        try:
            if path in tables and not has_columns(path):
                continue
            values, unit, by_name = read_times(path, files, needs_names=path in tables)
        except BadInput as error:
            account.assumed.append(f"{path} is left out: {_reason(error, path)}")
            continue
        if len(values) != len(files):
            account.assumed.append(f"{path} is left out: it has {len(values)} times for {len(files)} pictures")
            continue
        times = in_ns(values, unit or "s", options.stamp_unit, str(path), account, options.rate_hz)
        account.assumed.append(
            f"times are those of {path}, {'by the names in it' if by_name else 'one a picture in the order of their names'}"
        )
        return times
    return None


def _reason(error: BadInput, path: pathlib.Path) -> str:
    """Without the file, which is named before; a line's number stays."""
    reason = str(error).removeprefix(f"{path}:").strip()
    return "it lists no times" if reason == "lists no pictures" else reason
