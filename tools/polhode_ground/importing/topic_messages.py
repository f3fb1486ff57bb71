"""Which messages of a topic are taken: those of one camera, each once."""

import zlib
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.source import OTHER_CAMERA, RECORDED_TWICE, Account

SECOND_CAMERA_SHARE = 0.1  # of the messages; fewer are those of a driver that starts
CHANGES_OF_ONE_CAMERA = 3  # of its name: a driver that was started again, and not two cameras by turns
NO_STAMP_REPEATS = 3  # a stamp that comes more often tells nothing


def frame_id_of(message) -> str:
    return str(getattr(getattr(message, "header", message), "frame_id", "") or "").lstrip("/")


@dataclass
class TopicMessages:
    """Of all messages of the pictures' topic in their order."""

    stamps_ns: list[int] = field(default_factory=list)
    received_ns: list[int] = field(default_factory=list)
    frame_ids: list[str] = field(default_factory=list)
    sums: list[int] = field(default_factory=list)
    left_out: set[int] = field(default_factory=set)  # numbers of messages

    def add(self, message, stamp_ns: int, received_ns: int) -> None:
        self.stamps_ns.append(stamp_ns)
        self.received_ns.append(received_ns)
        self.frame_ids.append(frame_id_of(message))
        self.sums.append(zlib.crc32(np.ascontiguousarray(message.data) if isinstance(message.data, np.ndarray) else bytes(message.data)))

    def choose(self, camera: str, where: str, account: Account) -> None:
        self._choose_camera(camera, where, account)
        self._leave_out_repeats(account)

    def taken(self, values: list) -> list:
        return [value for number, value in enumerate(values) if number not in self.left_out]

    @property
    def frame_id(self) -> str:
        """Of the messages that are taken."""
        return next(iter(self.taken(self.frame_ids)), "")

    def _choose_camera(self, camera: str, where: str, account: Account) -> None:
        counts = Counter(self.frame_ids)
        if len(counts) < 2:
            return
        found = ", ".join(f"{name or 'none'} ({count})" for name, count in counts.most_common())
        changes = sum(a != b for a, b in zip(self.frame_ids, self.frame_ids[1:]))
        if camera in counts:
            self.left_out |= {number for number, name in enumerate(self.frame_ids) if name != camera}
            account.dropped[OTHER_CAMERA] += len(self.left_out)
            account.assumed.append(f"{where}: pictures of several frame_ids, {found}: those of {camera} are taken, as --camera says")
        elif counts.most_common()[1][1] >= SECOND_CAMERA_SHARE * len(self.frame_ids) and changes > CHANGES_OF_ONE_CAMERA:
            raise BadInput(
                f"{where}: pictures of {len(counts)} cameras by turns, by their frame_id: {found}; choose one by --camera {next(iter(counts))}"
            )
        else:
            account.assumed.append(f"{where}: the frame_id changes, {found}: taken to be one camera; --camera takes one of them")

    def _leave_out_repeats(self, account: Account) -> None:
        """Same stamp, same octets: two recorders at work, or a recording that was played twice."""
        times = Counter(self.stamps_ns)
        seen, again = set(), set()
        for number, key in enumerate(zip(self.stamps_ns, self.frame_ids, self.sums)):
            if number not in self.left_out and key in seen and times[key[0]] <= NO_STAMP_REPEATS:
                again.add(number)
            seen.add(key)
        if again:
            self.left_out |= again
            account.dropped[RECORDED_TWICE] += len(again)
