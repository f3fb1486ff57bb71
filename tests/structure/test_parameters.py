"""One truth about parameters: the option structs, the table of ranges and the comments say the same."""

import os
import pathlib
import re
import subprocess

import pytest
from source_tree import REPOSITORY

PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
SECTIONS = {
    "ImageOptions": "image", "MaskOptions": "mask", "FeatureOptions": "features", "TrackOptions": "tracks",
    "InitialOptions": "start", "LocaliseOptions": "localise", "MapOptions": "map", "ShapeOptions": "shape",
    "ScaleOptions": "scale", "MotionOptions": "motion", "BusOptions": "bus", "CameraParameters": "camera",
    "JobOptions": "jobs", "BudgetOptions": "budget",
}
NOT_SET_DIRECTLY: set[str] = set()
FIELD = re.compile(r"^\s+(?:bool|int|double|std::\w+(?:<.*>)?|ScaleSource|MotionMode|DynamicsKind)\s+(\w+)\s*(?:=[^;]*|\{\})?;(?:\s*///<(.*))?$")


def option_fields() -> dict[str, str]:
    """Dotted key -> comment, of every field of every option struct."""
    fields = {}
    for file in [*(REPOSITORY / "fsw").glob("*/options.hpp"), REPOSITORY / "fsw/pipeline/parameters.hpp"]:
        struct = None
        for line in file.read_text().splitlines():
            if match := re.match(r"struct (\w+) \{", line):
                struct = match.group(1)
            elif line.startswith("};"):
                struct = None
            elif struct and struct != "Parameters" and "operator" not in line and (match := FIELD.match(line)):
                fields[f"{SECTIONS[struct]}.{match.group(1)}"] = match.group(2) or ""
    return fields


@pytest.fixture(scope="module")
def table():
    """Dotted key -> allowed range, as the program tells it."""
    if not PROGRAM.exists():
        pytest.skip(f"{PROGRAM} is not built")
    text = subprocess.run([PROGRAM, "check", "--defaults"], capture_output=True, text=True, check=True).stdout
    ranges, section = {}, ""
    for line in text.splitlines():
        if match := re.match(r"\[(\w+)\]", line):
            section = match.group(1) + "."
        elif match := re.match(r"(?:# )?(\w+) = .*?# ([^;]*);", line):
            ranges[section + match.group(1)] = match.group(2)
    return ranges


# verifies: PRG-05
def test_every_option_is_in_the_table(table):
    assert set(option_fields()) - NOT_SET_DIRECTLY | {"seed"} == set(table)


def test_a_range_stands_in_the_table_alone(table):
    """Motion's and shape's comments still have theirs: there they are the table's."""
    wrong = []
    for key, comment in option_fields().items():
        told = re.search(r"(-?[\d.]+) \.\. (-?[\d.]+)$", comment.strip())
        ranges = re.match(r"(-?[\d.]+) \.\. (-?[\d.]+)", table.get(key, ""))
        if told and key.split(".")[0] not in ("motion", "scale", "shape"):
            wrong.append(f"{key}: its comment has a range")
        elif told and ranges and [float(x) for x in told.groups()] != [float(x) for x in ranges.groups()]:
            wrong.append(f"{key}: the comment says {told.group()}, the table {ranges.group()}")
    assert not wrong, "\n".join(wrong)
