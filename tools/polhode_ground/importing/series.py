"""Pictures of several cameras in one folder: left and right, cam0 and cam1, or each picture in two formats."""

import pathlib
import re
from collections import defaultdict

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.source import OTHER_CAMERA, Account

# Words that name a camera. "L" and "R" are those of stereo rigs.
CAMERA = re.compile(r"(?<![a-z])(left|right|l|r|cam(?:era)?[-_ ]?\d{1,2})(?![a-z\d])", re.IGNORECASE)
WORD = re.compile(r"[^\W\d_]+\d*|\d+")
WITHOUT = "no-"  # before words that names must not have
SAME_NUMBERS_SHARE = 0.8  # of each of two series that show the same moments
SERIES_MIN, SERIES_MAX = 3, 8


def of_one_camera(files: list[pathlib.Path], camera: str, account: Account) -> list[pathlib.Path]:
    """@errors BadInput where they are of several, and none has this word in its name"""
    series = _by_camera(files) or _by_words(files)
    if series is None:
        return files
    if not has_word(files, camera) or all(_is_meant(file, camera) for file in files):
        raise BadInput(
            f"{files[0].parent}: pictures of {len(series)} cameras or formats in one folder, by their names: {words_of_choice(series)}, "
            "or put those of one into a folder"
        )
    return choose(files, camera, OTHER_CAMERA, account, f"pictures of {len(series)} cameras or formats in one folder, {_found(series)}")


def has_word(files: list[pathlib.Path], word: str) -> bool:
    return any(_is_meant(file, word) for file in files)


def _is_meant(file: pathlib.Path, word: str) -> bool:
    """By a word of its name, or by words that it has not: no-mask, no-depth-mask."""
    without = word.casefold().removeprefix(WITHOUT).split("-") if word.casefold().startswith(WITHOUT) else []
    return word.casefold() in _words(file) or bool(without) and not _words(file) & set(without)


def choose(files: list[pathlib.Path], word: str, reason: str, account: Account, what: str) -> list[pathlib.Path]:
    """Those with the word in their names. @param reason  why the others are left out"""
    chosen = [file for file in files if _is_meant(file, word)]
    account.dropped[reason] += len(files) - len(chosen)
    by = (
        f"without {' and '.join(word[len(WITHOUT) :].split('-'))}"
        if not any(word.casefold() in _words(file) for file in chosen)
        else f"with '{word}'"
    )
    account.assumed.append(f"{what}: those {by} in their names are taken")
    return chosen


def words_of_choice(series: dict[str, list[pathlib.Path]]) -> str:
    """What is there, and how one of it is chosen."""
    first, *others = (set(WORD.findall(name)) for name in sorted(series))
    own, foreign = first - set().union(*others), set().union(*others) - first
    word = min(own) if own else f"{WITHOUT}{'-'.join(sorted(foreign))} for those without" if foreign else "WORD"
    return f"{_found(series)}; choose by a word of the names, as --camera {word}"


def _found(series: dict[str, list[pathlib.Path]]) -> str:
    return ", ".join(f"{name} ({len(members)})" for name, members in sorted(series.items()))


def _words(file: pathlib.Path) -> set[str]:
    name = file.name.casefold()
    return {*WORD.findall(name), *(re.sub(r"[-_ ]", "", found) for found in CAMERA.findall(file.stem.casefold()))}


def _by_camera(files: list[pathlib.Path]) -> dict | None:
    """By the words for cameras, where all names have one and they differ."""
    series = defaultdict(list)
    for file in files:
        found = CAMERA.search(file.stem)
        if found is None:
            return None
        series[re.sub(r"[-_ ]", "", found.group(1).casefold())].append(file)
    return series if 1 < len(series) <= SERIES_MAX else None


def _by_words(files: list[pathlib.Path]) -> dict | None:
    """By all that is no number, where the numbers are the same in each: rgb_001 and depth_001, 001.jpg and 001.heic."""
    series, numbers = defaultdict(list), defaultdict(set)
    for file in files:
        name = re.sub(r"\d+", "#", file.stem) + file.suffix.casefold()
        series[name].append(file)
        numbers[name].add(tuple(map(int, re.findall(r"\d+", file.stem))))
    if (
        not 1 < len(series) <= SERIES_MAX
        or any(len(members) < SERIES_MIN for members in series.values())
        or () in set().union(*numbers.values())
    ):
        return None
    shared = set.intersection(*numbers.values())
    # Names that differ in their suffix alone are formats of one picture, though not each may have both.
    formats = len({pathlib.PurePath(name).stem for name in series}) == 1
    if formats and len(shared) >= SAME_NUMBERS_SHARE * min(map(len, numbers.values())):
        return series
    return series if all(len(shared) >= SAME_NUMBERS_SHARE * len(one) for one in numbers.values()) else None
