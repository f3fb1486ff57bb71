"""Tables of text as spreadsheets and other tools write them: UTF-8 or UTF-16, commas, semicolons or tabs, decimal commas, remarks."""

import codecs
import csv
import pathlib
import re

from polhode_ground.common.errors import BadInput

DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")
UTF16 = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


def text_of(path: pathlib.Path, errors: str = "strict") -> str:
    """Without a mark of its order. @param errors  Python's: "surrogateescape" keeps names of any encoding"""
    try:
        octets = path.read_bytes()
        coding = UTF16.get(octets[:2]) or _without_mark(octets)
        return octets.decode(coding, errors).removeprefix("\ufeff")
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None
    except UnicodeDecodeError as problem:
        raise BadInput(f"{path}: not a CSV text file ({problem})") from None


def _without_mark(octets: bytes) -> str:
    """UTF-16 of figures has a zero in each pair."""
    begin = octets[:200]
    if len(begin) > 3 and begin[1::2].count(0) > 0.8 * len(begin[1::2]):
        return "utf-16-le"
    return "utf-16-be" if len(begin) > 3 and begin[::2].count(0) > 0.8 * len(begin[::2]) else "utf-8"


def separator_of(text: str) -> str:
    """Of the first line that is no remark: ';', a tab, ',' or ' ' for any white space."""
    line = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    return next((mark for mark in ";\t," if mark in line), " ")


def rows_of(text: str, separator: str) -> list[tuple[int, list[str]]]:
    """(number of the line, cells without white space around them) of lines that are not empty; decimal commas became points."""
    lines = text.splitlines(keepends=True)
    if separator == " ":
        rows = [(number, line.split()) for number, line in enumerate(lines, 1)]
    else:
        reader = csv.reader(lines, delimiter=separator)
        rows = [(reader.line_num, row) for row in reader]
    return [(number, [_number(cell.strip(), separator) for cell in row]) for number, row in rows if any(cell.strip() for cell in row)]


def _number(cell: str, separator: str) -> str:
    return cell.replace(",", ".") if separator != "," and DECIMAL_COMMA.fullmatch(cell) else cell
