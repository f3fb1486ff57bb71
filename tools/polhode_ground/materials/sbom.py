"""Writes the bill of materials of a built program: CycloneDX 1.6, JSON.

Listed with version and licence, from this machine's own records:
  - the Debian package of every library that the program loads, directly or by way of others, and which of them loads which
  - the header-only libraries that are compiled into it
  - every Python requirement of the tools (tools/requirements*.txt), and what those that are installed ask for

Examples:
  tools/sbom.py --out polhode.cdx.json
  tools/sbom.py --program build/flight-aarch64/bin/polhode --out polhode.cdx.json
"""

import argparse
import importlib.util
import pathlib
import re

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main

PROGRAM = REPOSITORY / "build/release/bin/polhode"


def bill_of(program: pathlib.Path) -> str:
    if not importlib.util.find_spec("cyclonedx"):
        raise BadInput("cyclonedx-python-lib is not installed; tools/setup.sh tests installs it")
    from polhode_ground.materials.bill import write_bill
    from polhode_ground.materials.debian import compiled_in, loaded_by
    from polhode_ground.materials.python import requirements

    libraries = loaded_by(program)
    version = re.search(r'kVersion = "([\d.]+)"', (REPOSITORY / "fsw/pipeline/component.hpp").read_text()).group(1)
    return write_bill(version, libraries, compiled_in(), requirements(sorted((REPOSITORY / "tools").glob("requirements*.txt"))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=PROGRAM, help="default: build/release/bin/polhode")
    parser.add_argument("--out", type=pathlib.Path, required=True, metavar="FILE.json")
    arguments = parser.parse_args()
    if not arguments.program.is_file():
        raise BadInput(f"{arguments.program}: no such program; tools/build.sh makes it")
    if not arguments.out.parent.is_dir():
        raise BadInput(f"--out: {arguments.out.parent}: no such folder")
    from polhode_ground.common.whole_file import check_replaceable, write_whole

    check_replaceable(arguments.out)
    enter_venv()
    write_whole(arguments.out, bill_of(arguments.program.resolve()))


def command() -> None:
    run_main(main, "sbom")
