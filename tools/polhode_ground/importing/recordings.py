"""Readers of recordings: bags by `rosbags`, MCAP files by `mcap`, folders of either, also those that a recorder left unfinished."""

import contextlib
import pathlib
from collections.abc import Collection, Iterator

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.db3_file import DamagedDb3
from polhode_ground.importing.mcap_file import McapFile, ros_store, words_of
from polhode_ground.importing.pictures import natural_order
from polhode_ground.importing.source import Account

SUFFIXES = (".bag", ".mcap", ".db3")


def is_recording(path: pathlib.Path) -> bool:
    return path.suffix.lower() in SUFFIXES or (path / "metadata.yaml").is_file() or bool(_parts(path))


def _parts(folder: pathlib.Path) -> list[pathlib.Path]:
    """The files of a bag of ROS 2, or those into which ROS 1 split one, in order."""
    if not folder.is_dir():
        return []
    return sorted((path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and path.is_file()), key=natural_order)


@contextlib.contextmanager
def opened(path: pathlib.Path):
    """A reader with `connections`, `messages`, `deserialize` as of rosbags, and `damage`: what is wrong with the file, in words."""
    with contextlib.ExitStack() as stack:
        parts = _parts(path)
        if not parts or _is_packed(path):
            yield _single(path, stack)
        elif (path / "metadata.yaml").is_file() and parts[0].suffix == ".db3":
            try:
                reader = RosBag(path, stack)
            except BadInput as problem:
                reader = Joined([_single(part, stack) for part in parts])
                reader.damage.append(f"metadata.yaml is left out: {problem}")
            yield reader
        else:
            yield Joined([_single(part, stack) for part in parts])


def _single(path: pathlib.Path, stack: contextlib.ExitStack):
    if path.suffix.lower() == ".mcap":
        return McapFile(path)
    try:
        return RosBag(path, stack)
    except BadInput as problem:
        if path.suffix.lower() != ".db3":
            raise
        return DamagedDb3(path, str(problem).removeprefix(f"{path}: not a bag that can be read ").strip("()"))


def _is_packed(path: pathlib.Path) -> bool:
    """ROS 2 packs files or single messages; only rosbags undoes that."""
    import yaml

    try:
        values = yaml.safe_load((path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
        return False
    return str(values.get("compression_mode") or "none").lower() != "none"


class RosBag:
    """Messages whose definition the bag does not hold are taken to be those of ROS 2 Humble."""

    def __init__(self, path: pathlib.Path, stack: contextlib.ExitStack):
        from rosbags.highlevel import AnyReader

        self.damage: list[str] = []
        try:
            self._reader = stack.enter_context(AnyReader([path], default_typestore=ros_store()))
        except Exception as problem:  # the library's errors have no common base class, and a torn file raises Python's own
            hint = "; it was not closed or is cut, `rosbag reindex` makes an index" if "ndex" in str(problem) else ""
            raise BadInput(f"{path}: not a bag that can be read ({words_of(problem)}{hint})") from None
        self.connections = list(self._reader.connections)

    def messages(self, connections: Collection) -> Iterator[tuple]:
        yield from self._reader.messages(connections=connections)

    def deserialize(self, raw, msgtype: str):
        return self._reader.deserialize(raw, msgtype)


class Joined:
    """Files of one recording, one after the other."""

    def __init__(self, readers: list):
        self._readers = readers
        self.damage: list[str] = []
        self.connections = [connection for reader in readers for connection in reader.connections]

    def messages(self, connections: Collection) -> Iterator[tuple]:
        for reader in self._readers:
            own = [one for one in reader.connections if any(one is other for other in connections)]
            for connection, time_ns, raw in reader.messages(own) if own else ():
                yield connection, time_ns, (reader, raw)
            self.damage += [text for text in reader.damage if text not in self.damage]

    def deserialize(self, raw, msgtype: str):
        reader, inner = raw
        return reader.deserialize(inner, msgtype)


def read_messages(reader, connections: Collection, account: Account) -> Iterator[tuple]:
    """(connection, time received, message) as far as they can be read; what is lost goes into the account."""
    read = 0
    try:
        for connection, received_ns, raw in reader.messages(connections):
            read += 1
            try:
                message = reader.deserialize(raw, connection.msgtype)
            except BadInput:
                raise
            except Exception:  # each encoding has errors of its own
                account.dropped["message can't be read"] += 1
                continue
            yield connection, received_ns, message
    except (BadInput, GeneratorExit):
        raise
    except Exception as problem:
        reader.damage.append(words_of(problem))
    if reader.damage:
        account.assumed.append(f"the recording is damaged: {'; '.join(reader.damage[:3])}")
    lost = sum(connection.msgcount or 0 for connection in connections) - read
    if lost > 0:
        account.dropped["missing in the recording, whose index promises them"] += lost
