"""Python packages that the tools ask for, with what their own records say."""

import importlib.metadata
import pathlib
import re

from .material import Material

PINNED = re.compile(r"^([A-Za-z0-9._-]+)(?:\[[^\]]*\])?==(\S+)", re.MULTILINE)
NAME = re.compile(r"[A-Za-z0-9._-]+")


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def licences_of(distribution: importlib.metadata.Distribution) -> tuple[str, ...]:
    """Expression, else classifiers, else the free text if it is a name and not the licence itself."""
    about = distribution.metadata
    if about["License-Expression"]:
        return (about["License-Expression"],)
    classified = [line.split("::")[-1].strip() for line in about.get_all("Classifier", []) if line.startswith("License ::")]
    text = (about["License"] or "").strip()
    return tuple(sorted(set(classified))) or ((text,) if text and len(text.splitlines()) == 1 else ("as in the package's licence file",))


def needs_of(distribution: importlib.metadata.Distribution) -> list[str]:
    """Names that it asks for without extras of its own."""
    return [normal(NAME.match(line).group()) for line in distribution.requires or [] if "extra ==" not in line]


def requirements(files: list[pathlib.Path]) -> list[Material]:
    """The pinned ones of these files, then what the installed ones of them draw in."""
    pinned = {normal(name): version for file in files for name, version in PINNED.findall(file.read_text())}
    installed = {normal(one.metadata["Name"]): one for one in importlib.metadata.distributions()}
    reached, queue = {}, list(pinned)
    while queue:
        name = queue.pop()
        if name not in reached and (name in installed or name in pinned):
            reached[name] = installed.get(name)
            queue += needs_of(installed[name]) if name in installed else []
    versions = {name: one.version if one else pinned[name] for name, one in reached.items()}
    purls = {name: f"pkg:pypi/{name}@{versions[name]}" for name in reached}
    return [
        Material(
            name,
            versions[name],
            licences_of(one) if one else ("not installed here: as in the package",),
            purls[name],
            "tool",
            name in pinned,
            tuple(sorted(purls[need] for need in (needs_of(one) if one else []) if need in purls and need != name)),
        )
        for name, one in sorted(reached.items())
    ]
