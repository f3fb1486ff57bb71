"""Pictures beside a numbered series that are none of its frames, by their names: backgrounds, dark frames, calibrations, copies."""

import os
import pathlib
import re
from collections import Counter, defaultdict

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.decoding import read_picture
from polhode_ground.importing.numbering import DATE_AND_CLOCK, HEX
from polhode_ground.importing.series import SERIES_MAX, SERIES_MIN, choose, has_word, words_of_choice
from polhode_ground.importing.source import COPIES, OTHER_SERIES, Account

SMALL_SHARE = 0.5  # of the series: a larger group may as well be what the user wants, and is asked for
NAMED = 3


def of_the_series(files: list[pathlib.Path], camera: str, account: Account) -> list[pathlib.Path]:
    """@errors BadInput where a group of other names is nearly as large as the series, and `camera` is a word of neither"""
    groups = _by_stem(files)
    members = max(groups.values(), key=len, default=[])
    if not _is_a_series(files, groups, members):
        return files
    formats = _in_another_format(members)
    series = [file for file in members if file not in formats]
    strange = _strangers(groups, series)
    originals = {file: original for file in strange if (original := _original(file, series))}
    copies = {file: original for file, original in originals.items() if _is_the_same(file, original)}
    # A name that has the second of the exposure is no count: another picture of that second is a frame.
    frames = {file for file in originals if file not in copies and DATE_AND_CLOCK.search(file.stem)}
    others = [file for file in files if file in strange - frames and file not in copies]
    if has_word(others, camera) and not has_word(series, camera):
        return choose(files, camera, OTHER_SERIES, account, f"pictures of {len(_by_stem(others)) + 1} series in one folder")
    if not has_word(series, camera):
        _ask_of_large_ones(series, others)
    _tell(formats | copies, others, series, account)
    return [file for file in files if file not in formats and file not in copies and file not in others]


def _pattern(file: pathlib.Path) -> str:
    """Seconds since 1970 with a fraction are one number."""
    return re.sub(r"\d{9,10}\.\d+|\d+", "#", file.stem.casefold())


def _by_stem(files: list[pathlib.Path]) -> dict[str, list[pathlib.Path]]:
    groups = defaultdict(list)
    for file in files:
        groups[_pattern(file)].append(file)
    return groups


def _is_a_series(files: list[pathlib.Path], groups: dict, members: list[pathlib.Path]) -> bool:
    """Whether names tell who belongs to it: most have its form, or few forms are there. Hexadecimal numbers have many."""
    begin = len(os.path.commonprefix([file.stem for file in files]))
    ends = [file.stem[begin:] for file in files]
    if all(map(HEX.fullmatch, ends)) and not all(map(str.isdecimal, ends)):
        return False
    return len(members) >= SERIES_MIN and "#" in _pattern(members[0]) and (2 * len(members) >= len(files) or len(groups) <= SERIES_MAX)


def _numbers(file: pathlib.Path) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r"\d+", file.stem)))


def _in_another_format(members: list[pathlib.Path]) -> dict[pathlib.Path, pathlib.Path]:
    """File by the one of the same name whose suffix is more frequent."""
    count = Counter(file.suffix.casefold() for file in members)
    best: dict[str, pathlib.Path] = {}
    for file in sorted(members, key=lambda one: -count[one.suffix.casefold()]):
        best.setdefault(file.stem, file)
    return {file: best[file.stem] for file in members if best[file.stem] is not file}


def _strangers(groups: dict[str, list[pathlib.Path]], series: list[pathlib.Path]) -> set[pathlib.Path]:
    pattern = _pattern(series[0])
    taken = {_numbers(file) for file in series}
    strange: set[pathlib.Path] = set()
    for other, members in groups.items():
        if other == pattern or pattern.startswith(other) and "#" not in other:  # img.png before img (1).png
            continue
        if other.split("#")[0] == pattern.split("#")[0] and "#" in other:  # IMG_3_edited in place of IMG_3
            strange |= {file for file in members if _original(file, series) or _numbers(file) in taken}
        elif not _goes_on(sorted(taken), sorted(map(_numbers, members))):
            strange |= set(members)
    return strange


def _goes_on(numbers: list[tuple[int, ...]], others: list[tuple[int, ...]]) -> bool:
    """Whether a group of other words counts on from the series, or up to it."""
    if {len(one) for one in (*numbers, *others)} != {1}:
        return False
    step = min(b[0] - a[0] for a, b in zip(numbers, numbers[1:])) or 1
    return 0 < others[0][0] - numbers[-1][0] <= step or 0 < numbers[0][0] - others[-1][0] <= step


def _original(file: pathlib.Path, series: list[pathlib.Path]) -> pathlib.Path | None:
    """Whose name is this one's beginning or end: img_003 (1), img_003 - Copy, Copy of img_003."""
    stem = file.stem.casefold()
    for one in series:
        name = one.stem.casefold()
        if stem != name and (
            stem.startswith(name) and not stem[len(name)].isalnum() or stem.endswith(name) and not stem[-len(name) - 1].isalnum()
        ):
            return one
    return None


def _is_the_same(file: pathlib.Path, original: pathlib.Path) -> bool:
    """By what it shows; a lossless copy in another format is one, too."""
    try:
        if file.read_bytes() == original.read_bytes():
            return True
        one, other = read_picture(file).pixels, read_picture(original).pixels
    except (BadInput, OSError):
        return False
    return one.shape == other.shape and np.array_equal(one, other)


def _ask_of_large_ones(series: list[pathlib.Path], others: list[pathlib.Path]) -> None:
    groups = _by_stem(others)
    large = {name: members for name, members in groups.items() if len(members) > SMALL_SHARE * len(series)}
    if large:
        found = {_pattern(series[0]): series, **large}
        raise BadInput(
            f"{series[0].parent}: pictures of {len(found)} series in one folder, by their names: {words_of_choice(found)}, or put those of one "
            "into a folder; names that count on from one another are one series"
        )


def _tell(copies: dict[pathlib.Path, pathlib.Path], others: list[pathlib.Path], series: list[pathlib.Path], account: Account) -> None:
    if copies:
        account.dropped[COPIES] += len(copies)
        account.assumed.append(
            f"{len(copies)} pictures are left out as copies: {_named([f'{file.name} of {copies[file].name}' for file in sorted(copies)])}"
        )
    if others:
        account.dropped[OTHER_SERIES] += len(others)
        hint = next(
            (f"; --camera and a word of their names, as {word}, takes them in its place" for word in _words_of_own(others, series)), ""
        )
        account.assumed.append(
            f"{len(others)} pictures are left out, as their names are not those of the series {_pattern(series[0])}: "
            f"{_named([file.name for file in others])}{hint}"
        )


def _named(names: list[str]) -> str:
    return f"{', '.join(names[:NAMED])}{f' and {len(names) - NAMED} more' if len(names) > NAMED else ''}"


def _words_of_own(others: list[pathlib.Path], series: list[pathlib.Path]) -> list[str]:
    words = re.findall(r"[^\W\d_]+", others[0].stem.casefold())
    return [word for word in words if not has_word(series, word)]
