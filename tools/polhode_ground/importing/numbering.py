"""Numbers in the names of pictures: their order, and where they jump, pictures are missing."""

import itertools
import os
import pathlib
import re
import statistics
from collections import Counter
from decimal import Decimal

from polhode_ground.common.units import is_impossible, median_step
from polhode_ground.importing.stamps import COUNTER_BITS

# Chosen: so many steps between numbers are alike where they count frames.
ALIKE_SHARE = 0.5
HEX_ALIKE_SHARE = 0.8  # letters may stand for much else
DATE_AND_CLOCK = re.compile(
    r"(?<!\d)((?:19|20)\d\d)[-_.]?([01]\d)[-_.]?([0-3]\d)(?:[-_T. ]| at )?([0-2]\d)[-_.:h]?([0-5]\d)[-_.:m]?([0-5]\d)(?:\.?(\d{3}|\d{6}|\d{9}))?(?!\d)"
)
# Behind a date and a clock: parts of a second, or a count of what was taken in that second.
FIELD_AFTER_CLOCK = re.compile(r"[-_.,s](\d{3}|\d{6}|\d{9})(?!\d)")
DECIMAL, FIGURES = re.compile(r"\d+(?:[.,](\d+))?"), "0123456789.,"
COUNT_STEP_MAX = 5  # chosen: counters that every fifth picture is kept of; few cameras take 200 pictures a second
NO_COUNT = "the numbers in the pictures' names are no count of frames: they are taken for an order only"
BEGINS_AGAIN = "the counter in the pictures' names begins again at its end"
HEX = re.compile(r"[0-9a-f]+|[0-9A-F]+")
ROLL_DIGITS_MIN, ROLL_NEAR = 3, 3  # counters of cameras begin again at 0 or 1; so many pictures may be missing there


def in_order(files: list[pathlib.Path]) -> tuple[list[pathlib.Path], list[str]]:
    """Files of one folder, which are in their names' order already: by hexadecimal counters, and over the end of a counter. What was done, in words."""
    hexadecimal = _hexadecimal([file.stem for file in files])
    if hexadecimal is not None:
        return [file for _, file in sorted(zip(hexadecimal, files))], ["the numbers in the pictures' names are hexadecimal"]
    decimals = decimals_of([file.stem for file in files])
    if decimals is not None:
        return [file for _, file in sorted(zip(decimals, files))], []
    place = _rolls_over(_digits([file.stem for file in files]))
    if not place:
        return files, []
    said = f"{BEGINS_AGAIN}: {files[-1].name} is followed by {files[0].name}"
    return files[place:] + files[:place], [said]


def decimals_of(stems: list[str]) -> list[Decimal] | None:
    """Decimal numbers between words that stay, 0.85 before 0.9; None of other names. Zeros at the ends of figures of unlike length are of
    no decimal number: 1.9 is followed by 1.10 in versions, and of seconds and unpadded nanoseconds nobody knows."""
    texts = [DATE_AND_CLOCK.sub("@", stem) for stem in stems]
    begin = len(os.path.commonprefix(texts).rstrip(FIGURES))
    end = len(os.path.commonprefix([text[: begin - 1 if begin else None : -1] for text in texts]).rstrip(FIGURES))
    found = [DECIMAL.fullmatch(text[begin : len(text) - end]) for text in texts]
    parts = [one[1] for one in found if one and one[1]]
    if None in found or not parts or len(set(map(len, parts))) > 1 and any(len(part) > 1 and part.endswith("0") for part in parts):
        return None
    return [Decimal(one[0].replace(",", ".")) for one in found]


def parts_of_seconds(stems: list[str]) -> list[str] | None:
    """The figures behind each name's date and clock, where they are parts of a second; None where they count pictures, one after the other."""
    clocks = [DATE_AND_CLOCK.search(stem) for stem in stems]
    fields = [clock and FIELD_AFTER_CLOCK.match(stem, clock.end()) for clock, stem in zip(clocks, stems)]
    if None in fields or len({len(field[1]) for field in fields}) != 1 or any(clock[7] for clock in clocks):
        return None
    step = median_step([int(field[1]) for field in fields])
    is_count = 0 < step <= COUNT_STEP_MAX or is_impossible(step * 10 ** (9 - len(fields[0][1])))
    return None if is_count else [field[1] for field in fields]


def _hexadecimal(stems: list[str]) -> list[int] | None:
    """Numbers of width that stays, with letters; None where they count nothing."""
    begin = len(os.path.commonprefix(stems))
    ends = [stem[begin:] for stem in stems]
    if len(ends) < 3 or len({len(end) for end in ends}) != 1 or not all(HEX.fullmatch(end) for end in ends):
        return None
    if all(end.isdecimal() for end in ends) or not any(end.isdecimal() for end in ends):
        return None
    values = [int(end, 16) for end in ends]
    return values if _counted(sorted(values), HEX_ALIKE_SHARE) is not None else None


def _rolls_over(digits: list[list[str]] | None) -> int:
    """Place of the first picture before a counter's end, where those after it come first in the names' order; 0 where it did not roll over."""
    if digits is None or len(digits) != 1:
        return 0
    numbers = [int(one) for one in digits[0]]
    steps = [b - a for a, b in zip(numbers, numbers[1:])]
    rolls = any(numbers[0] <= near and 0 < end - numbers[-1] <= near and max(steps) > end // 2 for end, near in _ends(digits[0]))
    return steps.index(max(steps)) + 1 if rolls else 0


def _ends(column: list[str]) -> list[tuple[int, float]]:
    """(a counter's end, how near to it the last number before it and the first after it are): of so many digits, or of so many bits."""
    numbers = [int(one) for one in column]
    step = statistics.median([abs(b - a) for a, b in zip(numbers, numbers[1:])])
    width = len(column[0])
    decimal = [(10**width, ROLL_NEAR)] if width >= ROLL_DIGITS_MIN and {len(one) for one in column} == {width} else []
    return decimal + [(2**bits, ROLL_NEAR * step) for bits in COUNTER_BITS if max(numbers) < 2**bits]


def frame_numbers(names: list[str]) -> tuple[list[int], str]:
    """(frame of each picture, counted from 0; in words what its number says of missing ones, else '').

    @param names  in order; in several folders each counts by itself, and one goes on after the other
    """
    frames, jumps, next_frame = [], [], 0
    for folder in _that_count_alike(names):
        numbers = numbers_of(folder)
        found = _counted(numbers) if numbers else list(range(len(folder)))
        if found is None or numbers is None and _hold_numbers(folder):
            return list(range(len(names))), NO_COUNT
        jumps += [(b - a - 1, before, after) for a, b, before, after in zip(found, found[1:], folder, folder[1:]) if b - a > 1]
        frames += [next_frame + frame for frame in found]
        next_frame = frames[-1] + 1
    return frames, _said(jumps)


def _that_count_alike(names: list[str]) -> list[list[str]]:
    """Names by folder; where several numbers differ in one, by what stands before the last: part 1, part 2."""
    folders = [list(group) for _, group in itertools.groupby(names, lambda name: pathlib.PurePath(name).parent)]
    groups = []
    for folder in folders:
        parts = [
            list(group) for _, group in itertools.groupby(folder, lambda name: re.sub(r"\d+(?=\D*$)", "", pathlib.PurePath(name).stem))
        ]
        groups += parts if numbers_of(folder) is None and 3 * len(parts) <= len(folder) else [folder]
    return groups


def _said(jumps: list[tuple[int, str, str]]) -> str:
    if not jumps:
        return ""
    _, before, after = max(jumps, key=lambda jump: jump[0])
    where = f"from {before} to {after}" if len(jumps) == 1 else f"{len(jumps)} times, most from {before} to {after}"
    return (
        f"the numbers in the pictures' names jump {where}: {sum(jump[0] for jump in jumps)} pictures are missing, the times keep the gaps"
    )


def _hold_numbers(names: list[str]) -> bool:
    """Two pictures or one tell no steps."""
    return len(names) > 2 and any(re.search(r"\d", pathlib.PurePath(name).stem) for name in names)


def _digits(stems: list[str]) -> list[list[str]] | None:
    """The numbers that differ, each of all names; None where the names differ in something else, too. A date and a clock are no number:
    125959 is followed by 130000."""
    parts = [re.split(r"(\d+)", DATE_AND_CLOCK.sub("@", stem)) for stem in stems]
    if len(stems) < 3 or len({tuple(part[::2]) for part in parts}) != 1:
        return None
    return [list(column) for column in list(zip(*parts))[1::2] if len(set(column)) > 1]


def numbers_of(names: list[str]) -> list[int | Decimal] | None:
    """The number that counts in each name; None where the names differ in something else, too, or several numbers differ and none or more of them count."""
    stems = [pathlib.PurePath(name).stem for name in names]
    if len(stems) > 3 and not stems[0][-1:].isdecimal() and stems[1].startswith(stems[0]):  # a copy without a number: img, img (1)
        rest = numbers_of(names[1:])
        return [rest[0] - 1, *rest] if rest else None
    alone = _hexadecimal(stems) or (decimals_of(stems) if len(stems) > 2 else None)
    if alone is not None:
        return alone
    columns = [_over_the_end(column) for column in _digits(stems) or []]
    if len(columns) == 1:
        return columns[0]
    counting = [column for column in columns if _counted(column) is not None]
    return counting[0] if len({tuple(_counted(column)) for column in counting}) == 1 else None


def _over_the_end(column: list[str]) -> list[int]:
    """Numbers that go on where a counter began again."""
    numbers = [int(one) for one in column]
    place = next((place for place, (a, b) in enumerate(zip(numbers, numbers[1:]), 1) if b < a), 0)
    end = next((end for end, near in _ends(column) if end - numbers[place - 1] <= near and numbers[place] <= near), 0) if place else 0
    end -= bool(end) and end == 10 ** len(column[0]) and numbers[place] == 1  # cameras' counters have no 0 (DCF)
    return numbers[:place] + [number + end for number in numbers[place:]]


def _counted(numbers: list[int], alike_share: float = ALIKE_SHARE) -> list[int] | None:
    """Frames from 0 by the usual step between the numbers; None where they do not count frames."""
    steps = [b - a for a, b in zip(numbers, numbers[1:])]
    usual, count = Counter(steps).most_common(1)[0]
    usual = min(usual, type(usual)(statistics.median(steps)))
    if usual <= 0 or count < alike_share * len(steps) or any(step <= 0 or step % usual for step in steps):
        return None
    return [int((number - numbers[0]) // usual) for number in numbers]
