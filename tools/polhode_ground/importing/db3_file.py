"""A bag's file of SQLite that is cut or damaged: its messages from both ends, as far as its pages can be read."""

import pathlib
import sqlite3
from collections.abc import Collection, Iterator

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.mcap_file import Connection, ros_decoder


class DamagedDb3:
    """Offers what `recordings.py` uses of rosbags' reader."""

    def __init__(self, path: pathlib.Path, why: str):
        self.path, self.damage = path, [why]
        try:
            rows = self._database().execute("SELECT id, name, type FROM topics").fetchall()
        except sqlite3.Error as problem:
            raise BadInput(f"{path}: not a bag that can be read ({why}; its topics: {problem})") from None
        self.connections = [Connection(number, topic, kind, None, "cdr") for number, topic, kind in rows]
        self._decoders = {}

    def _database(self):
        database = sqlite3.connect(f"{self.path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
        database.execute("PRAGMA writable_schema = ON")  # else a file that is shorter than its header says is not read at all
        return database

    def _rows(self, order: str) -> Iterator[tuple]:
        try:
            yield from self._database().execute(f"SELECT id, topic_id, timestamp, data FROM messages ORDER BY id {order}")
        except sqlite3.Error:
            yield None

    def messages(self, connections: Collection[Connection]) -> Iterator[tuple]:
        by_id, last = {one.id: one for one in connections}, 0
        for row in self._rows("ASC"):
            if row is None:
                break
            last = row[0]
            if row[1] in by_id:
                yield by_id[row[1]], row[2], row[3]
        else:
            return
        rest = []
        for row in self._rows("DESC"):
            if row is None or row[0] <= last:
                break
            rest.append(row)
        upto = rest[-1][0] if rest else last + 1
        self.damage.append(f"messages {last + 1} to {upto - 1} can't be read" if rest else f"messages from {last + 1} on can't be read")
        yield from ((by_id[topic], time_ns, data) for _, topic, time_ns, data in reversed(rest) if topic in by_id)

    def deserialize(self, raw: bytes, msgtype: str):
        if msgtype not in self._decoders:
            self._decoders[msgtype] = ros_decoder(self._definition(msgtype), "ros2msg", "cdr", msgtype)
        return self._decoders[msgtype](raw)

    def _definition(self, msgtype: str) -> str:
        """Bags before ROS 2 Iron have no table of them."""
        try:
            found = (
                self._database()
                .execute(
                    "SELECT encoded_message_definition FROM message_definitions WHERE topic_type = ? AND encoding = 'ros2msg'", (msgtype,)
                )
                .fetchone()
            )
        except sqlite3.Error:
            return ""
        return found[0] if found else ""
