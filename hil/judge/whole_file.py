"""Files that are there whole or as they were before, whatever a full disk or an interruption leaves of the writing."""

import contextlib
import os
import pathlib
import uuid
from collections.abc import Iterator


@contextlib.contextmanager
def beside(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """A place to write to, of the same suffix, that becomes `path` when all went well and vanishes when not.

    A link stays and its target is replaced; what is no file, as /dev/null, is written to as it is.
    """
    path = pathlib.Path(os.path.realpath(path))
    if path.exists() and not path.is_file():
        yield path
        return
    part = path.with_name(f".{uuid.uuid4().hex[:8]}-{path.name}")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: pathlib.Path, content: str | bytes) -> None:
    """Makes the folder, too. OSError names `path`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with beside(path) as part:
            part.write_bytes(content if isinstance(content, bytes) else content.encode())
    except OSError as problem:
        problem.filename = str(path)
        raise
