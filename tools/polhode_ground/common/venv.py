"""Entry of every Python script: run inside the repository's own virtual environment, end with one line on bad input."""

import errno
import os
import pathlib
import sys
from collections.abc import Callable

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
# All problems here are small: threads of the linear algebra gain nothing and, on a busy machine, spin against each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


# Neither the variables that a shell has for another Python nor the user's own packages: they would hide the project's. Text is UTF-8,
# and names of files in another encoding are printed as they are, whatever the shell's language is.
ISOLATED = ("-E", "-s", "-X", "utf8")


def is_isolated() -> bool:
    return bool(sys.flags.ignore_environment and sys.flags.no_user_site and sys.flags.utf8_mode)


def own_environment() -> dict[str, str]:
    """Without other Pythons' variables; the interpreters that are started from here get it, too."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | {
        "PYTHONNOUSERSITE": "1",
        "PYTHONUTF8": "1",
    }


def enter_venv(name: str = ".venv") -> None:
    """Re-executes this script by the interpreter of REPOSITORY/name, if that exists, isolated, unless that is running."""
    home = REPOSITORY / name
    python = home / "bin" / "python3"
    if not python.exists():
        home, python = pathlib.Path(sys.prefix), pathlib.Path(sys.executable)
    if pathlib.Path(sys.prefix).resolve() != home.resolve() or not is_isolated():
        os.execve(python, [str(python), *ISOLATED, *sys.argv], own_environment())


def run_main(main: Callable[[], int | None], program: str) -> None:
    """Calls main(); bad input, and a file or folder that is refused, become one line on stderr and exit status 2, a full disk one line and 1, a closed
    pipe a quiet end."""
    environment = own_environment()
    os.environ.clear()
    os.environ.update(environment)
    try:
        from polhode_ground.common.errors import BadInput

        sys.exit(main())
    except ImportError as problem:
        sys.exit(f"{program}: {problem}; run tools/setup.sh once, it installs tools/requirements.txt into .venv")
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except BadInput as problem:
        print(f"{program}: {problem}", file=sys.stderr)
        sys.exit(2)
    except OSError as problem:
        is_full = problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        if not is_full and not problem.filename:
            raise
        place = f"{problem.filename}: " if problem.filename else ""
        print(f"{program}: {place}{problem.strerror}", file=sys.stderr)
        sys.exit(1 if is_full else 2)
