"""Figures of the house that may only fall. ratchets.toml holds them; run as a command, this prints them.

Headers and sources that tools/generate_bus.py writes are left out: their size is that of config/bus/*.toml."""

import argparse
import ast
import dataclasses
import pathlib
import re
import sys
import tomllib

from cpp_parts import MEMBERS_MAX, comments_of, constants, head_parts, structs_of
from source_tree import REPOSITORY, ROOTS, code_of, cpp_definitions, is_generated, name_of, own_includes, source_files

HELD = pathlib.Path(__file__).with_name("ratchets.toml")
PARAMETERS_MAX = 5
SHOWN_MAX = 20  # places that a message names
WHOLE_STATE = re.compile(r"(?:Component::)?State\s*[*&]")
CHOSEN = re.compile(r"\bchosen\b", re.IGNORECASE)
# Written so that these lines do not match themselves.
PATH_LINE = re.compile(r"\bsys\.path\b")
SILENCED_LINE = re.compile(r"#\s*(?:noqa\b|type:\s*ignore|(?:fmt|mypy|pylint|ruff):)")

ASSERTION = re.compile(r"\bPOLHODE_ASSERT\([^;]*;")
EFFECT = re.compile(r"\bpush_back\(|\binsert\(|\btake\(|\+\+|--|[^=!<>]=[^=]")

Graph = dict[pathlib.Path, set[pathlib.Path]]


@dataclasses.dataclass
class Figure:
    number: int
    places: list[str]  # the worst first where they differ


def counted(places: list[str]) -> Figure:
    return Figure(len(places), places)


def written_by_hand(*roots: str) -> list[pathlib.Path]:
    return [file for file in source_files(*roots, suffixes=(".cpp", ".hpp")) if not is_generated(file)]


def room_of(file: pathlib.Path) -> str:
    return file.relative_to(REPOSITORY / "fsw").parts[0]


def functions_of(files: list[pathlib.Path]) -> list[tuple[str, list[str]]]:
    """Place with name, and parameters, of each function that is defined."""
    found = []
    for file in files:
        for line, _, head in cpp_definitions(file):
            name, parameters = head_parts(head)
            found.append((f"{name_of(file)}:{line}: {name}", parameters))
    return found


def with_whole_state(files: list[pathlib.Path]) -> Figure:
    return counted([place for place, parameters in functions_of(files) if any(map(WHOLE_STATE.match, parameters))])


def with_many_parameters(files: list[pathlib.Path]) -> Figure:
    found = [(len(parameters), place) for place, parameters in functions_of(files) if len(parameters) > PARAMETERS_MAX]
    return counted([f"{place} has {number}" for number, place in sorted(found, key=lambda one: -one[0])])


def wide_structs(files: list[pathlib.Path]) -> dict[str, Figure]:
    return {name: Figure(members, [f"{name_of(file)}:{line}"]) for file in files for name, line, members in structs_of(file)
            if members > MEMBERS_MAX}


def constants_by_room(files: list[pathlib.Path]) -> dict[str, Figure]:
    places: dict[str, list[str]] = {}
    for file in files:
        places.setdefault(room_of(file), []).extend(
            f"{name_of(file)}:{first + 1}: {name}" for name, first, _, number in constants(file.read_text()) if number)
    return {room: counted(found) for room, found in places.items()}


def comments_with_chosen(files: list[pathlib.Path]) -> Figure:
    return counted([f"{name_of(file)}:{line}" for file in files for line, text in comments_of(file.read_text()) if CHOSEN.search(text)])


def code_lines(files: list[pathlib.Path]) -> Figure:
    lines = [(sum(bool(line.strip()) for line in code_of(file).splitlines()), name_of(file)) for file in files]
    return Figure(sum(number for number, _ in lines), [f"{name}: {number} lines" for number, name in sorted(lines, reverse=True)])


def assertions_with_effects(files: list[pathlib.Path]) -> Figure:
    """What an assertion changes hides in a place that is read as a check."""
    return counted([f"{name_of(file)}:{code_of(file)[:match.start()].count(chr(10)) + 1}" for file in files
                    for match in ASSERTION.finditer(code_of(file)) if EFFECT.search(match.group())])


def documents() -> list[pathlib.Path]:
    return sorted([*REPOSITORY.glob("*.md"), *source_files(*ROOTS, "docs", suffixes=(".md",))])


def hundreds_of_words(files: list[pathlib.Path]) -> Figure:
    """Begun ones: a sentence more or less is none of this figure's business."""
    numbers = {name_of(file): len(file.read_text().split()) for file in files}
    return Figure(-(-sum(numbers.values()) // 100), [f"{name}: {number} words" for name, number in sorted(numbers.items(), key=lambda one: -one[1])])


def matching_lines(pattern: re.Pattern, files: list[pathlib.Path]) -> Figure:
    return counted([f"{name_of(file)}:{number}" for file in files
                    for number, line in enumerate(file.read_text().splitlines(), 1) if pattern.search(line)])


def include_graph(files: list[pathlib.Path]) -> Graph:
    """Between units: a header, or a header with the source of its name."""
    units = {file.with_suffix("") for file in files}
    graph: Graph = {unit: set() for unit in units}
    for file in files:
        for include in own_includes(file):
            bases = (file.parent, REPOSITORY / "fsw", REPOSITORY / "platform", REPOSITORY)
            found = next((unit for base in bases if (unit := (base / include).with_suffix("")) in units), None)
            graph[file.with_suffix("")] |= {found} - {None, file.with_suffix("")}
    return graph


def imports_of(file: pathlib.Path) -> list[tuple[str, list[str]]]:
    """Module with its dots, and names, of each import, those within functions too."""
    found = []
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found += [(alias.name, []) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found.append(("." * node.level + (node.module or ""), [alias.name for alias in node.names]))
    return found


def import_graph(files: list[pathlib.Path]) -> Graph:
    """A module is found by the end of its path, as tests name their helpers without their folder; of several the nearest counts."""
    by_stem: dict[str, list[pathlib.Path]] = {}
    for file in files:
        by_stem.setdefault(file.parent.name if file.stem == "__init__" else file.stem, []).append(file)

    def resolved(module: str, importer: pathlib.Path) -> pathlib.Path | None:
        dots = len(module) - len(module.lstrip("."))
        parts = tuple(module[dots:].split("."))
        if not dots and parts[0] in sys.stdlib_module_names:
            return None
        found = []
        for file in by_stem.get(parts[-1], []):
            place = file.parent if file.stem == "__init__" else file.with_suffix("")
            folder = place.parents[len(parts) - 1]
            if place.parts[-len(parts):] == parts and (not dots or folder == importer.parents[dots - 1]):
                found.append(file)
        common = [sum(a == b for a, b in zip(file.parts, importer.parts)) for file in found]
        return found[common.index(max(common))] if found else None

    graph: Graph = {}
    for file in files:
        others = set()
        for module, names in imports_of(file):
            inner = [resolved(f"{module}{'' if module.endswith('.') else '.'}{name}", file) for name in names]
            others |= {one or (resolved(module, file) if module.strip(".") else None) for one in inner or [None]}
        graph[file] = others - {None, file}
    return graph


def cycles(graph: Graph) -> Figure:
    """Groups in which each reaches each other one."""

    def reached_from(start: pathlib.Path) -> set[pathlib.Path]:
        seen, left = set(), [start]
        while left:
            new = graph[left.pop()] - seen
            seen |= new
            left += new
        return seen

    reached = {node: reached_from(node) for node in graph}
    groups = {frozenset(other for other in others if node in reached[other]) for node, others in reached.items() if node in others}
    return counted(sorted(" and ".join(sorted(map(name_of, group))) for group in groups))


def all_figures() -> dict[str, Figure]:
    fsw, python = written_by_hand("fsw"), source_files(suffixes=(".py",))
    figures = {
        "whole_state_functions": with_whole_state(fsw),
        "many_parameter_functions": with_many_parameters(written_by_hand("fsw", "platform")),
        "chosen_comments": comments_with_chosen(fsw),
        "fsw_code_lines": code_lines(fsw),
        "assertions_with_effects": assertions_with_effects(fsw),
        "include_cycles": cycles(include_graph(source_files("fsw", "platform", suffixes=(".cpp", ".hpp")))),
        "import_cycles": cycles(import_graph(python)),
        "search_path_lines": matching_lines(PATH_LINE, python),
        "documents": counted([name_of(file) for file in documents()]),
        "hundreds_of_words": hundreds_of_words(documents()),
        "silenced_lines": matching_lines(SILENCED_LINE, python),
    }
    figures |= {f"wide_structs.{name}": figure for name, figure in wide_structs(fsw).items()}
    figures |= {f"constants.{room}": figure for room, figure in constants_by_room(fsw).items() if room != "bus"}
    return figures


def held_figures() -> dict[str, int]:
    """Of a table's entries the keys are TABLE.ENTRY."""
    held = {}
    for key, value in tomllib.loads(HELD.read_text()).items():
        held |= {f"{key}.{entry}": number for entry, number in value.items()} if isinstance(value, dict) else {key: value}
    return held


def complaint(name: str, now: Figure, held: int) -> str:
    """Empty where the figure is the one that is held."""
    if not now.number and "." in name:
        return f"{name} is gone: take it out of {name_of(HELD)}"
    if now.number < held:
        return f"{name} has fallen to {now.number}: lower the figure in {name_of(HELD)} to {now.number}, now {held}"
    if now.number > held:
        more = [f"and {len(now.places) - SHOWN_MAX} more: python {name_of(pathlib.Path(__file__))} {name}"] if len(now.places) > SHOWN_MAX else []
        return "\n".join([f"{name} is {now.number}, held at {held}:", *now.places[:SHOWN_MAX], *more])
    return ""


def main() -> int:
    parser = argparse.ArgumentParser(description="Prints the figures, what is held, or all places of one.")
    parser.add_argument("figure", nargs="?", help="print its places, one a line")
    name, figures, held = parser.parse_args().figure, all_figures(), held_figures()
    if name and name not in figures:
        parser.error(f"{name}: allowed is {', '.join(figures)}")
    if name:
        print("\n".join(figures[name].places))
        return 0
    print(f"{'figure':<32}{'now':>8}{'held':>8}")
    for key in sorted(figures.keys() | held.keys()):
        print(f"{key:<32}{figures.get(key, counted([])).number:>8}{held.get(key, 0):>8}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
