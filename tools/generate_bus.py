#!/usr/bin/env -S python3 -Es -X utf8
"""Writes everything that follows from the bus's field table (config/bus/*.toml): C++ structs and layout, the C and Python
clients' tables, the XTCE and the CSV files for ccsdspy. The interface control document is written where it is wanted.

  tools/generate_bus.py                             writes what differs
  tools/generate_bus.py --check                     writes nothing; exit status 1 names the files that are out of date
  tools/generate_bus.py --document interface.md     writes the interface control document alone: packets and commands, octet by octet
"""

import argparse
import pathlib
import sys

from polhode_ground.busgen import c_client, ccsdspy_csv, cpp, display, document, python_client, xtce, xtce_commands
from polhode_ground.busgen.table import TableError, read_table

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]

WRITER = b"tools/generate_bus.py"  # stands in each document


def generated(table) -> dict[str, str]:
    """Path in the repository -> text."""
    files = {}
    for part in (cpp, c_client, python_client, xtce, xtce_commands, ccsdspy_csv, display):
        files.update(part.files(table))
    return files


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing, tell what is out of date")
    parser.add_argument("--document", type=pathlib.Path, metavar="FILE.md", help="write the interface control document alone")
    arguments = parser.parse_args()
    try:
        table = read_table(REPOSITORY / "config/bus")
    except TableError as problem:
        print(f"generate_bus: {problem}", file=sys.stderr)
        return 2
    if arguments.document:
        try:
            if arguments.document.is_file() and WRITER not in arguments.document.read_bytes():
                print(f"generate_bus: --document: {arguments.document}: is there already and was not made by this command", file=sys.stderr)
                return 2
            arguments.document.write_text(document.interface_control(table))
        except OSError as problem:
            print(f"generate_bus: --document: {problem}", file=sys.stderr)
            return 2
        return 0
    files = generated(table)
    old = [name for name, text in files.items()
           if not (REPOSITORY / name).exists() or (REPOSITORY / name).read_text() != text]
    for name in old:
        if arguments.check:
            print(f"{name} is out of date: run tools/generate_bus.py", file=sys.stderr)
            continue
        (REPOSITORY / name).parent.mkdir(parents=True, exist_ok=True)
        (REPOSITORY / name).write_text(files[name])
        print(f"written: {name}")
    return 1 if old and arguments.check else 0


if __name__ == "__main__":
    sys.exit(main())
