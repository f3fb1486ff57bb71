"""Makes the site: guides, decisions, interfaces, requirements, known limits and the API, by Sphinx, Doxygen and Breathe.

    tools/setup.sh site          once: installs these
    tools/make_site.py           build/site/html/index.html

A warning of any of them, or a link within the site that leads nowhere, is an error. Other sites are not asked.
"""

import argparse
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main
from polhode_ground.verification.catalogue import read_stages
from polhode_ground.verification.requirements_matrix import rows_of, write_pages
from polhode_ground.verification.tests import read_tests
from polhode_ground.website.links import dead_links
from polhode_ground.website.pages import copy_pages


def version() -> str:
    return re.search(r'kVersion = "([\d.]+)"', (REPOSITORY / "fsw/pipeline/component.hpp").read_text())[1]


def write_source(source: pathlib.Path) -> None:
    """All that Sphinx reads."""
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    copy_pages(REPOSITORY, source)
    subprocess.run([sys.executable, REPOSITORY / "tools/generate_bus.py", "--document", source / "docs/interface_control.md"], check=True)
    stages = read_stages(REPOSITORY)
    write_pages(source / "docs/requirements", stages, rows_of(stages, read_tests(REPOSITORY)[0], {}))
    settings = (REPOSITORY / "docs/site/Doxyfile").read_text() + f'OUTPUT_DIRECTORY = "{source}/doxygen"\n'
    subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=REPOSITORY, check=True)


def make_site(out: pathlib.Path) -> int:
    write_source(out / "source")
    shutil.rmtree(out / "html", ignore_errors=True)
    subprocess.run(
        [
            sys.executable,
            "-m",
            "sphinx",
            "-W",
            "--keep-going",
            "-q",
            "-j",
            "auto",
            "-d",
            out / "doctrees",
            "-b",
            "html",
            out / "source",
            out / "html",
        ],
        env={**os.environ, "POLHODE_VERSION": version()},
        check=True,
    )
    dead = dead_links(out / "html")
    if dead:
        print("\n".join(dead), file=sys.stderr)
        return 1
    print(f"{out / 'html/index.html'}: {len(list((out / 'html').rglob('*.html')))} pages, no dead link")
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status 0: made; 1: a warning or a dead link; 2: something is not installed.",
    )
    parser.add_argument(
        "--out",
        type=pathlib.Path,
        default=REPOSITORY / "build/site",
        metavar="FOLDER",
        help="gets html/, and source/ beside it; default: build/site",
    )
    out = parser.parse_args().out.resolve()
    from polhode_ground.common.whole_file import claim_folder

    claim_folder(out, ".polhode-site", "source/docs/interface_control.md")
    enter_venv()
    missing = [name for name in ("sphinx", "myst_parser", "breathe") if not importlib.util.find_spec(name)]
    missing += [] if shutil.which("doxygen") else ["doxygen"]
    if missing:
        raise BadInput(f"not installed: {', '.join(missing)}; tools/setup.sh site installs them")
    try:
        return make_site(out)
    except subprocess.CalledProcessError as problem:
        print(f"make_site: {problem.cmd[0] if problem.cmd[0] == 'doxygen' else 'sphinx'} failed, see above", file=sys.stderr)
        return 1


def command() -> None:
    run_main(main, "make_site")
