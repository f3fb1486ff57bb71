"""Files that are there whole or as they were before, whatever a full disk or an interruption leaves of the writing.

What was there before is somebody's: a file is replaced only if it bears our mark, a folder is filled only if it is new, empty
or bears the mark's file, and what is not ready yet has a name that nobody has.
"""

import contextlib
import os
import pathlib
import uuid
from collections.abc import Iterator

from polhode_ground.common.errors import BadInput

MARK = "Made by Polhode"  # in the first or the last octets of each file that may be replaced by a later call
MARK_WITHIN_OCTETS = 1 << 16
REPLAY_MARK = ".polhode-replay"  # the program's, in the folders of its results


def bears_mark(path: pathlib.Path) -> bool:
    """Nothing is lost of an empty file either."""
    with open(path, "rb") as stream:
        octets = os.fstat(stream.fileno()).st_size
        first = stream.read(MARK_WITHIN_OCTETS)
        stream.seek(max(0, octets - MARK_WITHIN_OCTETS))
        return octets == 0 or MARK.encode() in first or MARK.encode() in stream.read()


def check_replaceable(path: pathlib.Path) -> None:
    """@raise BadInput where a file or folder of others is in the way."""
    try:
        if path.is_dir() or (path.is_file() and not bears_mark(path)):
            raise BadInput(
                f"{path}: is there already and was not made by this command, or by a version that left no mark in it; move it away or give another name"
            )
    except OSError as problem:
        raise BadInput(f"{path}: {problem.strerror}") from None


def fresh_beside(path: pathlib.Path) -> pathlib.Path:
    """A name that nobody has, in the same folder and of the same suffix."""
    return path.with_name(f".{uuid.uuid4().hex[:8]}-{path.name}")


def claim_folder(folder: pathlib.Path, mark: str, *others: str) -> None:
    """Makes the folder, with its mark's file in it. @raise BadInput where it holds files and no mark: they are somebody's.

    @param others  files that tell as well that it is ours
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / mark).exists():
            if any(folder.iterdir()) and not any((folder / name).exists() for name in others):
                raise BadInput(
                    f"{folder}: holds other files, or those of a version that left no mark ({mark}); allowed is a new, an empty or an earlier call's folder"
                )
            (folder / mark).touch()
    except OSError as problem:
        raise BadInput(f"{folder}: {problem.strerror}") from None


@contextlib.contextmanager
def beside(path: pathlib.Path, ours: bool = False) -> Iterator[pathlib.Path]:
    """A place to write to, of the same suffix, that becomes `path` when all went well and vanishes when not.

    A link stays and its target is replaced; what is no file, as /dev/null, is written to as it is.
    @param ours  the file may be replaced though it bears no mark, as in a folder that we have claimed
    """
    path = pathlib.Path(os.path.realpath(path))
    if not ours:
        check_replaceable(path)
    if path.exists() and not path.is_file():
        yield path
        return
    part = fresh_beside(path)
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: pathlib.Path, content: str | bytes, ours: bool = False) -> None:
    """Makes the folder, too. OSError names `path`. A name that is not UTF-8 stands in the text as it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with beside(path, ours) as part:
            part.write_bytes(content if isinstance(content, bytes) else content.encode(errors="surrogateescape"))
    except OSError as problem:
        problem.filename = str(path)
        raise
