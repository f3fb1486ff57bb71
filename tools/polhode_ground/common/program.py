"""The program that a script runs, and the new folder that a campaign writes into."""

import os
import pathlib

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY

# That of the release build, unless POLHODE_PROGRAM names another.
PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
# What runs it where it is of another architecture.
RUNNER = os.environ.get("POLHODE_RUNNER", "").split()


def check_program() -> None:
    """@raise BadInput where it is not there, or may not be run."""
    if not PROGRAM.is_file() or not os.access(PROGRAM, os.X_OK):
        raise BadInput(f"{PROGRAM}: not there or not a program; build it first")


def new_folder(folder: pathlib.Path) -> pathlib.Path:
    """Made, with those above it. @raise BadInput where something is there, or it cannot be made. @return its full path."""
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        raise BadInput(f"{folder}: is there already") from None
    except OSError as problem:
        raise BadInput(f"{folder}: {problem.strerror}") from None
    return folder.resolve()
