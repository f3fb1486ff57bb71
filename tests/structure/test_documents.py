"""Documents that a stranger can read: short sentences, links and paths that lead somewhere, an index of decisions that is complete.

The limits hold for prose. Fenced code, tables and headings are left out; a bullet or an empty line ends a sentence, and so does
. ! ? or ; before white space. A word is whatever stands between spaces and has a letter or a digit in it."""

import pathlib
import re
import statistics

import pytest
from source_tree import REPOSITORY, code_of, name_of

MEDIAN_WORDS_MAX = 20
SENTENCE_WORDS_MAX = 40
DECISIONS = REPOSITORY / "docs/decisions"

DOCUMENTS = [REPOSITORY / "README.md", REPOSITORY / "CONTRIBUTING.md"]
DOCUMENTS += [file for root in ("fsw", "platform", "hil", "tools") for file in sorted((REPOSITORY / root).rglob("README.md"))]
DOCUMENTS += sorted((REPOSITORY / "docs").glob("*.md"))
DOCUMENTS += sorted(DECISIONS.glob("*.md")) + [REPOSITORY / "docs/requirements/README.md"]

FENCED = re.compile(r"^[ \t]*```.*?^[ \t]*```[ \t]*$", re.DOTALL | re.MULTILINE)
HEADING_OR_TABLE = re.compile(r"^[ \t]*(?:#{1,6}[ \t]|\|).*$", re.MULTILINE)
BULLET = re.compile(r"^[ \t]*(?:[-*+]|\d+\.)[ \t]+(?:\[[ xX]\][ \t]+)?", re.MULTILINE)
LINK = re.compile(r"!?\[([^\]]*)\]\(([^()\s]*)\)")
SENTENCE_END = re.compile(r"(?<=[.!?;])[)*_\"'\]]*\s+")

CODE = re.compile(r"`([^`\n]+)`")
REPOSITORY_PATH = re.compile(r"(?:fsw|platform|hil|tools|tests|config|docs)/[\w./-]*")
FLIGHT_PATH = re.compile(r"(?:fsw|platform)/[\w./-]*")
NAME = re.compile(r"(?:\w+::)*([A-Za-z_]\w*)(?:\(\))?")  # of a function, type or constant
PLACEHOLDER = re.compile(r"\b(?!README\b|CONTRIBUTING\b)[A-Z]+\b")  # SEQ, NAME, NNNN: to be filled in by the reader
ADDRESS = re.compile(r"[a-z]+:|#")  # a link to another site or within the page


def sentences_of(text: str) -> list[str]:
    """The sentences of a page's prose, without the marks that only set it."""
    text = HEADING_OR_TABLE.sub("\n\n", FENCED.sub("\n\n", text))
    text = LINK.sub(r"\1", BULLET.sub("\n\n", text))
    pieces = [piece for paragraph in re.split(r"\n\s*\n", text) for piece in SENTENCE_END.split(paragraph.strip())]
    return [" ".join(piece.split()) for piece in pieces if words_of(piece)]


def words_of(sentence: str) -> int:
    return sum(any(character.isalnum() for character in word) for word in sentence.split())


def too_long(text: str) -> list[str]:
    """What is wrong with the lengths of a page's sentences; empty where nothing is."""
    sentences = sentences_of(text)
    wrong = [f"{words} words: {sentence}" for sentence in sentences if (words := words_of(sentence)) > SENTENCE_WORDS_MAX]
    median = statistics.median(map(words_of, sentences)) if sentences else 0
    return wrong + ([f"the median is {median} words"] if median > MEDIAN_WORDS_MAX else [])


def paths_of(text: str) -> list[str]:
    """Names in code font that stand for a file or folder of the repository."""
    names = CODE.findall(FENCED.sub("", text))
    return [name for name in names if REPOSITORY_PATH.fullmatch(name) and not PLACEHOLDER.search(name)]


def links_of(text: str) -> list[str]:
    """Relative links, without the place within the page."""
    targets = [target for _, target in LINK.findall(CODE.sub("", FENCED.sub("", text)))]
    return [target.split("#")[0] for target in targets if target and not ADDRESS.match(target)]


def missing_from(folder: pathlib.Path, text: str, repository: pathlib.Path = REPOSITORY) -> list[str]:
    """What a page in a folder names and is not there."""
    wrong = [f"link to {link}" for link in links_of(text) if not (folder / link).exists()]
    return wrong + [f"path {path}" for path in paths_of(text) if not (repository / path).exists()]


def misplaced_in(text: str, repository: pathlib.Path = REPOSITORY) -> list[str]:
    """Names in code font that stand in none of the files of fsw and platform which their sentence names."""
    wrong = []
    for sentence in sentences_of(text):
        codes = CODE.findall(sentence)
        paths = [repository / code for code in codes if FLIGHT_PATH.fullmatch(code)]
        files = [file for path in paths for file in ([path] if path.is_file() else path.rglob("*")) if file.suffix in (".cpp", ".hpp")]
        words = {word for file in files for word in re.findall(r"\w+", code_of(file))}
        wrong += [f"{code} is not in {', '.join(str(path.relative_to(repository)) for path in paths)}" for code in codes
                  if words and (name := NAME.fullmatch(code)) and name.group(1) not in words]
    return wrong


def index_errors(index: str, files: set[str]) -> list[str]:
    """Where an index and the files beside it differ."""
    listed = {link for link in links_of(index) if "/" not in link} | set(re.findall(r"`(\d+-[\w-]+\.md)`", index))
    listed.discard("README.md")
    return [f"{name} is not in the index" for name in sorted(files - listed)] + \
           [f"{name} is in the index only" for name in sorted(listed - files)]


PAGE = """# A heading of the page is no sentence. Never.
One fact, one sentence! A second one goes
over two lines; a third follows. Version 2.5 of `a.b` is one piece?
| a table. | is no prose. |
- **In:** a bullet ends the sentence before it
- (Closed within its bracket.) [A link](there.md#place) counts by its text, [to nowhere](gone.md), [elsewhere](https://example.org/gone.md).
```
Code is left out. All of it, `docs/fenced.md` and [this](fenced.md).
```
`docs/there.md` `docs/` `docs/gone.md` `docs/*.md` `docs/NAME.md` `other/gone.md` `[e](code.md)`.
`map::first()` in `fsw/map/one.cpp`. `first` and `second` in `fsw/map/`. `second` alone; `--third` of `fsw/map/one.cpp`.
"""


def test_what_is_wrong_with_a_page_is_found(tmp_path):
    for name, text in (("docs/there.md", ""), ("fsw/map/one.cpp", "namespace map { int first() { return 1; } }  // second\n")):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    assert [words_of(sentence) for sentence in sentences_of(PAGE)][:8] == [4, 7, 3, 7, 8, 4, 9, 7]
    assert too_long("word " * SENTENCE_WORDS_MAX + ". Two words. Two words.") == []
    assert too_long("word " * (SENTENCE_WORDS_MAX + 1)) == [f"41 words: {'word ' * 41}".strip(), "the median is 41 words"]
    assert missing_from(tmp_path / "docs", PAGE, tmp_path) == ["link to gone.md", "path docs/gone.md"]
    assert misplaced_in(PAGE, tmp_path) == ["second is not in fsw/map"]
    index = "[One](0001-one.md), `0002-two.md`, [gone](0003-gone.md#x), [another page](../results.md), [itself](README.md)"
    assert index_errors(index, {"0001-one.md", "0002-two.md", "0004-new.md"}) == ["0004-new.md is not in the index", "0003-gone.md is in the index only"]


def test_documents_are_found_at_all():
    names = {name_of(file) for file in DOCUMENTS}
    assert {"README.md", "CONTRIBUTING.md", "fsw/base/README.md", "platform/README.md", "tools/polhode_ground/judge/README.md", "docs/bus.md"} <= names


@pytest.mark.parametrize("file", DOCUMENTS, ids=name_of)
def test_sentences_are_short(file):
    wrong = too_long(file.read_text())
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("file", DOCUMENTS, ids=name_of)
def test_links_and_paths_lead_somewhere(file):
    wrong = missing_from(file.parent, file.read_text())
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("file", DOCUMENTS, ids=name_of)
def test_what_a_sentence_names_stands_in_the_files_that_it_names(file):
    wrong = misplaced_in(file.read_text())
    assert not wrong, "\n".join(wrong)


@pytest.mark.skipif(not DECISIONS.is_dir(), reason="docs/decisions is not there")
def test_the_index_of_decisions_is_complete():
    files = {file.name for file in DECISIONS.glob("*.md")}
    assert "README.md" in files, "docs/decisions has no index"
    files.remove("README.md")
    wrong = index_errors((DECISIONS / "README.md").read_text(), files)
    assert files and not wrong, "\n".join(wrong)
