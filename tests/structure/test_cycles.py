"""No unit of fsw includes itself by way of others; a unit is a header with the source of its name."""

import pathlib

from source_tree import REPOSITORY, own_includes, source_files

FSW = REPOSITORY / "fsw"


def unit_of(place: str) -> str:
    return str(pathlib.PurePosixPath(place).with_suffix(""))


def arrows() -> dict[str, set[str]]:
    found = {}
    for file in source_files("fsw", suffixes=(".cpp", ".hpp")):
        unit = unit_of(str(file.relative_to(FSW)))
        found.setdefault(unit, set()).update(unit_of(include) for include in own_includes(file))
    return {unit: {other for other in others if other in found and other != unit} for unit, others in found.items()}


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Units that are left when those without an arrow into what is left have gone, one after the other."""
    left = {unit: set(others) for unit, others in graph.items()}
    while True:
        ends = {unit for unit, others in left.items() if not others & left.keys()}
        if not ends:
            break
        left = {unit: others for unit, others in left.items() if unit not in ends}
    # What only leads into a cycle is no part of one.
    while True:
        starts = {unit for unit in left if not any(unit in others for others in left.values())}
        if not starts:
            return [sorted(left)] if left else []
        left = {unit: others for unit, others in left.items() if unit not in starts}


# verifies: CMP-07
def test_there_is_no_include_cycle():
    assert len(arrows()) > 150
    assert not cycles(arrows())


def test_a_cycle_is_found():
    assert cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == [["b", "c"]]
    assert cycles({"a": {"b"}, "b": set()}) == []
