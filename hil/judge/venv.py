"""Entry of every Python script: run inside the repository's own virtual environment, end with one line on bad input."""

import errno
import os
import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
# All problems here are small: threads of the linear algebra gain nothing and, on a busy machine, spin against each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def enter_venv(name: str = ".venv") -> None:
    """Re-executes this script by the interpreter of REPOSITORY/name, if that exists and is not the one running."""
    home = REPOSITORY / name
    python = home / "bin" / "python3"
    if python.exists() and pathlib.Path(sys.prefix).resolve() != home.resolve():
        os.execv(python, [str(python), *sys.argv])


def run_main(main, program: str) -> None:
    """Calls main(); bad input becomes one line on stderr and exit status 2, a full disk one line and 1, a closed pipe a quiet end."""
    try:
        from judge.errors import BadInput
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
        if problem.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise
        place = f"{problem.filename}: " if problem.filename else ""
        sys.exit(f"{program}: {place}{problem.strerror}")
