"""The site: made without a warning, with all that it is for, and without a link that leads nowhere."""

import fnmatch
import importlib.util
import pathlib
import shutil
import subprocess
import sys

import pytest
from polhode_ground.website.links import dead_links
from polhode_ground.website.pages import copy_pages, documents_of

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


NEEDED = {"doxygen": shutil.which("doxygen")} | {name: importlib.util.find_spec(name) for name in ("sphinx", "myst_parser", "breathe")}
MISSING = [name for name, found in NEEDED.items() if not found]


def make(out: pathlib.Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, REPOSITORY / "tools/make_site.py", "--out", out], capture_output=True, text=True, timeout=900)


@pytest.mark.slow
@pytest.mark.further
@pytest.mark.skipif(bool(MISSING), reason=f"not installed: {', '.join(MISSING)}: tools/setup.sh site")
def test_it_is_made_without_a_warning_or_a_dead_link(tmp_path):
    done = make(tmp_path / "site")
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert done.stdout.endswith("no dead link\n")
    html = tmp_path / "site/html"
    pages = {file.relative_to(html).as_posix() for file in html.rglob("*.html")}
    assert {document.with_suffix(".html").as_posix() for document in documents_of(REPOSITORY)} <= pages
    assert {"docs/requirements/06-map.html", "docs/interface_control.html", "docs/known_limits.html", "fsw/map/README.html"} <= pages
    api = (html / "api_c.html").read_text()
    for name in ("polhode_step", "polhode_memory_needed", "polhode_output", "bounded work"):
        assert name.lower() in api.lower(), name
    assert all(name in (html / "api_cpp.html").read_text() for name in ("memory_needed", "StepOutput", "MotionState", "mid-exposure"))


def page(folder: pathlib.Path, name: str, body: str) -> None:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(f"<html><body>{body}</body></html>")


def test_dead_links_are_found(tmp_path):
    page(tmp_path, "index.html", '<a href="sub/other.html#place">a</a><a href="#here">b</a><p id="here"></p><img src="picture.png">'
                                 '<a href="https://example.org/gone">c</a><a href="mailto:x@example.org">d</a><a href="sub/a%20b.html">e</a>')
    page(tmp_path, "sub/other.html", '<p id="place"></p><a href="../index.html">a</a>')
    page(tmp_path, "sub/a b.html", "")
    (tmp_path / "picture.png").write_bytes(b"")
    assert dead_links(tmp_path) == []
    page(tmp_path, "sub/other.html", '<a href="../gone.html">a</a><a href="#gone">b</a>')
    (tmp_path / "picture.png").unlink()
    assert dead_links(tmp_path) == ["index.html: picture.png: no such file", "index.html: sub/other.html#place: no such place",
                                    "other.html: #gone: no such place", "other.html: ../gone.html: no such file"]


def test_pages_bring_what_they_link_to(tmp_path):
    copy_pages(REPOSITORY, tmp_path)
    for name in ("README.md", "docs/report.jpg", "LICENSE", "docs/decisions/README.md", "fsw/map/README.md", "index.md", "conf.py"):
        assert (tmp_path / name).is_file(), name
    assert not (tmp_path / "tests").exists()


def test_every_document_is_copied():
    names = {document.as_posix() for document in documents_of(REPOSITORY)}
    written = {file.relative_to(REPOSITORY).as_posix() for root in ("fsw", "platform", "docs") for file in (REPOSITORY / root).rglob("*.md")}
    assert {name for name in written if not name.startswith("docs/site/")} <= names


def test_every_document_is_named_in_the_sites_contents():
    contents = [line for line in (REPOSITORY / "docs/site/index.md").read_text().splitlines() if line and line[0] not in "`:#"]
    left_out = [document.as_posix() for document in documents_of(REPOSITORY)
                if not any(fnmatch.fnmatchcase(document.with_suffix("").as_posix(), entry) for entry in contents)]
    assert left_out == []


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "letter.txt").write_text("dear")
    done = make(tmp_path)
    assert done.returncode == 2 and done.stderr.startswith(f"make_site: {tmp_path}: holds other files, or those of a version that left no mark")
    assert [file.name for file in tmp_path.iterdir()] == ["letter.txt"]
