"""Where a campaign's files are, under names that are made of what they come from; each is whole or absent.

What is made is written beside its place and moved there when it is whole. A lock keeps two workers from making the same
thing. A process that is started inherits the lock, so that it is free only when nobody can write any more.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import pathlib
import shutil
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from polhode_ground.common.venv import REPOSITORY
from polhode_ground.common.whole_file import beside


def digest(*parts: Any) -> str:
    """32 hex digits that name content: parts are text, octets, or plain data."""
    total = hashlib.sha256()
    for part in parts:
        octets = part if isinstance(part, bytes) else part.encode() if isinstance(part, str) else json.dumps(part, sort_keys=True).encode()
        total.update(len(octets).to_bytes(8, "big") + octets)
    return total.hexdigest()[:32]


def file_digest(path: pathlib.Path) -> str:
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()[:32]


def source_digest(*patterns: str) -> str:
    """Of all files of the repository that match, with their names."""
    files = sorted({file for pattern in patterns for file in REPOSITORY.glob(pattern) if file.is_file()})
    return digest(*[part for file in files for part in (str(file.relative_to(REPOSITORY)), file.read_bytes())])


def folder_digest(folder: pathlib.Path) -> str:
    """Of a sequence that is there: names and content of all its files."""
    files = sorted(pathlib.Path(place) / name for place, _, names in os.walk(folder, followlinks=True) for name in names)
    return digest(*[part for file in files for part in (str(file.relative_to(folder)), file_digest(file))])


@dataclass(frozen=True)
class Store:
    """out: the campaign's folder. cache: what other campaigns use, too."""

    out: pathlib.Path
    cache: pathlib.Path

    def rendered(self, key: str) -> pathlib.Path:
        return self.cache / "scenes" / key

    def transformed(self, key: str) -> pathlib.Path:
        return self.cache / "transformed" / key

    def run(self, key: str) -> pathlib.Path:
        return self.out / "runs" / key

    def result(self, key: str) -> pathlib.Path:
        return self.out / "results" / key

    def time(self, key: str) -> pathlib.Path:
        return self.out / "times" / key

    def limit(self, key: str) -> pathlib.Path:
        return self.cache / "limits" / key

    def input(self, key: str, name: str) -> pathlib.Path:
        """A copy of a file as it was when the campaign read it."""
        return self.out / "inputs" / key / name

    def log(self, kind: str, key: str) -> pathlib.Path:
        return self.out / "logs" / f"{kind}_{key}.log"


def is_whole(place: pathlib.Path) -> bool:
    """A folder that is filled in place is whole when its list of frames is there, which is written last; others appear whole."""
    return (place / "mav0/cam0/data.csv").is_file() if place.parent.name == "scenes" else place.is_dir()


@contextlib.contextmanager
def locked(place: pathlib.Path) -> Iterator[int]:
    """Waits until nobody else makes `place`. @return the lock's file descriptor, for processes that write there."""
    locks = place.parent / ".locks"
    locks.mkdir(parents=True, exist_ok=True)
    with open(locks / place.name, "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield lock.fileno()


@contextlib.contextmanager
def appearing(place: pathlib.Path) -> Iterator[pathlib.Path]:
    """A folder to fill that becomes `place` when all went well, and vanishes when not. The lock of `place` is held."""
    for leftover in place.parent.glob(f"{place.name}.part-*"):
        shutil.rmtree(leftover)
    part = place.with_name(f"{place.name}.part-{uuid.uuid4().hex[:8]}")
    part.mkdir(parents=True)
    try:
        yield part
        os.rename(part, place)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def keep_copy(source: pathlib.Path, place: pathlib.Path) -> None:
    """What is run is what was hashed, whatever becomes of the source meanwhile."""
    if not place.is_file():
        place.parent.mkdir(parents=True, exist_ok=True)
        with beside(place, ours=True) as part:
            shutil.copy2(source, part)
