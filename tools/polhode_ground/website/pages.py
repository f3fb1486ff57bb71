"""The source of the site: a copy of the repository's documents in a tree like the repository's own, so that their links hold."""

import pathlib
import re
import shutil

from polhode_ground.common.errors import BadInput

DOCUMENTS = (
    "*.md",
    "docs/*.md",
    "docs/decisions/*.md",
    "docs/requirements/README.md",
    "fsw/*/README.md",
    "platform/README.md",
    "platform/*/*/README.md",
    "hil/*/README.md",
    "tools/polhode_ground/*/README.md",
)
LINK = re.compile(r"\]\(([^()\s:#]+)(?:#[^()\s]*)?\)")
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.DOTALL | re.MULTILINE)


def documents_of(repository: pathlib.Path) -> list[pathlib.Path]:
    """Relative to the repository."""
    return sorted(file.relative_to(repository) for pattern in DOCUMENTS for file in repository.glob(pattern))


def linked_files(repository: pathlib.Path, document: pathlib.Path) -> list[pathlib.Path]:
    """Pictures and whatever else a document links to, relative to the repository."""
    targets = LINK.findall(CODE.sub("", (repository / document).read_text()))
    files = [(repository / document.parent / target).resolve() for target in targets if not target.endswith(".md")]
    return [file.relative_to(repository) for file in files if file.is_file() and file.is_relative_to(repository)]


def copy_pages(repository: pathlib.Path, folder: pathlib.Path) -> None:
    documents = documents_of(repository)
    if pathlib.Path("README.md") not in documents:
        raise BadInput(f"{repository}: no README.md")
    for document in documents:
        for file in (document, *linked_files(repository, document)):
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(repository / file, folder / file)
    for file in ("conf.py", "index.md", "api_c.md", "api_cpp.md"):
        shutil.copy(repository / "docs/site" / file, folder)
