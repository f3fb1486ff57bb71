"""Runs the estimator on a sequence, and the folder where results are kept between calls."""

import os
import pathlib
import subprocess
from collections.abc import Iterable

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import REPOSITORY

PROGRAM = REPOSITORY / "build/release/bin/polhode"
CONFIG = REPOSITORY / "config/default.toml"
# A process's peak memory counts what it was before its program was loaded: a copy of us, with all that we have read. A
# small shell in between has nothing to pass on.
APART = ("sh", "-c", '"$@"; exit $?', "sh")


def cache_folder(*parts: str) -> pathlib.Path:
    """A place outside the tree: $POLHODE_CACHE, else polhode in the user's cache."""
    base = os.environ.get("POLHODE_CACHE")
    root = pathlib.Path(base) if base else (pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "polhode")
    return root.joinpath(*parts)


def replay(
    sequence: pathlib.Path, out: pathlib.Path, settings: Iterable[str] = (), config: pathlib.Path = CONFIG, program: pathlib.Path = PROGRAM
) -> None:
    """polhode replay with settings "key=value"; BadInput with the program's last line where it fails."""
    words = [word for setting in settings for word in ("--set", setting)]
    if not os.access(program, os.X_OK):
        raise BadInput(f"{program}: not there or not a program; build it first")
    done = subprocess.run(
        [*APART, program, "replay", "--config", config, "--sequence", sequence, "--out", out, *words],
        capture_output=True,
        text=True,
        errors="backslashreplace",
    )
    if done.returncode != 0:
        last = " ".join(done.stderr.strip().splitlines()[-1:])
        raise BadInput(f"{sequence}: the replay ended with {done.returncode}: {last}")
