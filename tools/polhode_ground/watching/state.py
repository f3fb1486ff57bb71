"""What the page shows, as plain data: taken from the packets one by one, bounded however long the run is."""

import copy
import math
import time
from collections import deque
from dataclasses import dataclass, field

from polhode_bus import Packet, name_of, words_of

EVENTS_MAX = 20
RATES_S = 60.0  # of the frames' time
RATES_MAX = 3600  # frames of that time at 60 frames/s; of faster cameras the last ones
POSES_MAX = 64  # a recorded frame may be later than its packets by the slots that wait for the disk
CLOUD_POINTS_MAX = 20_000  # more do not make the body plainer, and a viewer has to carry them


@dataclass(frozen=True)
class Pose:
    """T to C: p_C = R(q_CT) p_T + p_CT; q is w, x, y, z; lengths in m or map units."""

    q_CT: tuple[float, float, float, float]
    p_CT: tuple[float, float, float]


@dataclass(frozen=True)
class Rate:
    """w_T in deg/s and its 1-sigma, worst axis, at a frame's time."""

    timestamp_ns: int
    w_T_deg_s: tuple[float, float, float]
    sigma_deg_s: float


@dataclass(frozen=True)
class Event:
    timestamp_ns: int
    severity: str
    text: str


@dataclass
class State:
    """The newest packet of each kind by its name, and what is kept of earlier ones."""

    latest: dict[str, Packet] = field(default_factory=dict)
    packets: int = 0
    frames: int = 0  # motion packets
    poses: dict[int, Pose] = field(default_factory=dict)  # by the frame's time, the last ones
    rates: deque[Rate] = field(default_factory=lambda: deque(maxlen=RATES_MAX))
    events: deque[Event] = field(default_factory=lambda: deque(maxlen=EVENTS_MAX))  # the newest first
    cloud_T: list[tuple[float, float, float]] = field(default_factory=list)
    cloud_number: tuple[int, int] = (-1, -1)  # of the request, and points of it so far: changes when the cloud does
    arrived_s: float = 0.0  # monotonic time of the last packet; 0: none yet
    missing: int = 0  # packets, by their counts
    damaged_octets: int = 0

    def take(self, packet: Packet) -> None:
        self.packets += 1
        self.arrived_s = time.monotonic()
        take = {"motion": self._take_motion, "event": self._take_event, "platform_event": self._take_event, "cloud": self._take_cloud}.get(
            packet.name
        )
        if take is not None:
            take(packet)
        self.latest[packet.name] = packet

    def _take_motion(self, packet: Packet) -> None:
        self.frames += 1
        before = self.latest.get("motion")
        if before is not None and before.scale_number != packet.scale_number:  # another unit of length, or another map
            self.latest.pop("shape", None)
            self.cloud_T, self.cloud_number = [], (-1, -1)
        if packet.pose_valid:
            self.poses.pop(packet.timestamp_ns, None)
            self.poses[packet.timestamp_ns] = Pose(tuple(packet.q_CT), tuple(packet.p_CT))
            if len(self.poses) > POSES_MAX:
                del self.poses[next(iter(self.poses))]
        while self.rates and self.rates[-1].timestamp_ns >= packet.timestamp_ns:  # another run
            self.rates.pop()
        if packet.rate_valid:
            self.rates.append(
                Rate(packet.timestamp_ns, tuple(math.degrees(w) for w in packet.w_T_rad_s), math.degrees(packet.sigma_rate_rad_s))
            )
        while self.rates and packet.timestamp_ns - self.rates[0].timestamp_ns > RATES_S * 1e9:
            self.rates.popleft()

    def _take_event(self, packet: Packet) -> None:
        words = words_of(packet) if packet.name == "event" else ""
        text = packet.text or (name_of(packet, "id") if packet.name == "event" else f"platform event {packet.id}")
        self.events.appendleft(Event(packet.timestamp_ns, packet.severity, f"{text} ({words})" if words and words not in text else text))

    def _take_cloud(self, packet: Packet) -> None:
        if packet.cloud != self.cloud_number[0]:
            self.cloud_T = []
        room = CLOUD_POINTS_MAX - len(self.cloud_T)
        self.cloud_T = self.cloud_T + [tuple(point) for point in packet.p_T[: min(packet.points, room)]]  # anew: a copy may be being drawn
        self.cloud_number = (packet.cloud, len(self.cloud_T))

    @property
    def pose(self) -> Pose | None:
        motion = self.latest.get("motion")
        return self.poses.get(motion.timestamp_ns) if motion is not None and motion.pose_valid else None

    def snapshot(self) -> "State":
        """As it is now; later packets do not change it."""
        taken = copy.copy(self)
        taken.latest, taken.poses, taken.rates, taken.events = dict(self.latest), dict(self.poses), self.rates.copy(), self.events.copy()
        return taken
