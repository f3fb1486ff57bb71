"""The requirements of docs/requirements/*.toml, and what is wrong with the way in which they are stated."""

import dataclasses
import pathlib
import re
import tomllib

from polhode_ground.common.errors import BadInput

METHODS = ("test", "analysis", "inspection")
FIELDS = {"text", "source", "reason", "method", "evidence"}
IDENTIFIER = re.compile(r"[A-Z]{3}-\d{2}")
# interfaces: INTERFACES.md, which is kept with the paper, outside of the repository
SOURCE = re.compile(r"(paper|interfaces|card): (.+)|decision (\d{4})|(docs/\S+\.md)")


@dataclasses.dataclass(frozen=True)
class Requirement:
    identifier: str
    text: str
    source: str
    reason: str
    method: str
    evidence: str = ""


@dataclasses.dataclass(frozen=True)
class Stage:
    """One file: its name without suffix, its first comment, its requirements in order."""

    name: str
    title: str
    requirements: tuple[Requirement, ...]


def read_stage(file: pathlib.Path) -> Stage:
    text = file.read_text()
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise BadInput(f"{file}: {problem}") from None
    found = []
    for identifier, table in tables.items():
        if not isinstance(table, dict) or not all(isinstance(value, str) for value in table.values()):
            raise BadInput(f"{file}: {identifier}: not a table of texts")
        missing = {"text", "source", "reason", "method"} - set(table)
        if missing or set(table) - FIELDS:
            raise BadInput(
                f"{file}: {identifier}: needs text, source, reason, method, and may have evidence; "
                f"{', '.join(sorted(missing | (set(table) - FIELDS)))}"
            )
        found.append(Requirement(identifier, **table))
    title = text.partition("\n")[0]
    if not title.startswith("# "):
        raise BadInput(f"{file}: the first line is a comment that names the stage")
    return Stage(file.stem, title[2:], tuple(found))


def read_stages(repository: pathlib.Path) -> list[Stage]:
    files = sorted((repository / "docs/requirements").glob("*.toml"))
    if not files:
        raise BadInput(f"{repository}/docs/requirements: no requirements")
    return [read_stage(file) for file in files]


def source_exists(source: str, repository: pathlib.Path) -> bool:
    found = SOURCE.fullmatch(source)
    if not found:
        return False
    kind, place, decision, document = found.groups()
    if decision:
        return any(re.search(rf"\b{decision}\b", note.read_text()) for note in (repository / "docs/decisions").glob("*.md"))
    if document:
        return (repository / document).is_file()
    if kind == "card":  # a heading of the README
        return bool(re.search(rf"^#+ {re.escape(place)}$", (repository / "README.md").read_text(), re.MULTILINE))
    return True


def faults_of(stages: list[Stage], repository: pathlib.Path) -> list[str]:
    """What is wrong with the requirements themselves."""
    faults, seen = [], set()
    for stage in stages:
        letters = {one.identifier[:3] for one in stage.requirements}
        if len(letters) != 1:
            faults.append(f"{stage.name}: one set of three letters a file, not {', '.join(sorted(letters)) or 'none'}")
        for one in stage.requirements:
            name = one.identifier
            if not IDENTIFIER.fullmatch(name):
                faults.append(f"{name}: three capitals, a dash and two digits are an id")
            if name in seen:
                faults.append(f"{name} stands in two files")
            seen.add(name)
            if one.method not in METHODS:
                faults.append(f"{name}: method {one.method}: allowed is {', '.join(METHODS)}")
            if not source_exists(one.source, repository):
                faults.append(
                    f"{name}: source {one.source}: allowed is paper: SECTION, interfaces: SECTION, card: HEADING of the README, "
                    "decision NNNN, docs/FILE.md; it must be there"
                )
            if one.method != "test" and not (repository / one.evidence).is_file():
                faults.append(f"{name}: {one.method} needs evidence, a file of the repository")
    return faults
