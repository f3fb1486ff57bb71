"""Does what a campaign's book still asks for, on Dask's workers, and tells how far it is."""

import collections
import json
import pathlib
import sys
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field

from distributed import Client, Future, as_completed
from distributed.client import FutureCancelledError
from distributed.scheduler import KilledWorker

from polhode_ground.campaigns.book import Chain
from polhode_ground.campaigns.store import is_whole
from polhode_ground.campaigns.tasks import KINDS, Outcome, Task, perform
from polhode_ground.common.whole_file import write_whole

LINE_EVERY_S = 20.0  # without a terminal
FAILURES_FILE = "failures.json"
SESSIONS_FILE = "sessions.jsonl"

Futures = dict[Future[Outcome], Task]


class SchedulerLost(Exception):
    """The scheduler is gone; what was finished is there."""


@dataclass
class Progress:
    """How many tasks of each kind are done, and how long the rest will take by those that were."""

    todo: dict[str, int]
    workers: int
    done: collections.Counter[str] = field(default_factory=collections.Counter)
    failed: int = 0
    seconds: dict[str, float] = field(default_factory=lambda: collections.defaultdict(float))
    start_s: float = field(default_factory=time.monotonic)
    told_s: float = 0.0

    def add(self, outcome: Outcome) -> None:
        self.failed += not outcome.ok
        if outcome.not_tried:  # it took no time, and says nothing of those to come
            self.todo[outcome.task.kind] -= 1
            return
        self.done[outcome.task.kind] += 1
        self.seconds[outcome.task.kind] += outcome.wall_s

    def left_s(self) -> float | None:
        """None while some kind has not been seen. Runs that are timed alone take as long as a replay, one after the other."""
        together = alone = 0.0
        for kind, count in self.todo.items():
            seen = kind if self.done[kind] or kind != "time" else "replay"
            left = count - self.done[kind]
            if left <= 0:
                continue
            if self.done[seen] == 0:
                return None
            each_s = self.seconds[seen] / self.done[seen]
            together, alone = (together, alone + left * each_s) if kind == "time" else (together + left * each_s, alone)
        return together / max(self.workers, 1) + alone

    def text(self) -> str:
        parts = [f"{kind} {self.done[kind]}/{count}" for kind, count in self.todo.items() if count]
        left = self.left_s()
        parts.append(f"{self.failed} failed" if self.failed else "none failed" if parts else "everything is done")
        parts.append("" if left is None else f"{int(left) // 60} min {int(left) % 60:02d} s left")
        return ", ".join(part for part in parts if part)

    def tell(self, last: bool = False) -> None:
        terminal = sys.stderr.isatty()
        if not last and time.monotonic() - self.told_s < (0.5 if terminal else LINE_EVERY_S):
            return
        self.told_s = time.monotonic()
        print(("\r\033[K" if terminal else "") + self.text(), end="" if terminal and not last else "\n", file=sys.stderr, flush=True)


def _submit(client: Client, chains: list[Chain]) -> Futures:
    """{future: its task} with a future for each missing task, each waiting for the one before it in its chain.

    Keys are of this call alone: another campaign on the same scheduler may want the same thing elsewhere.
    """
    futures: dict[str, tuple[Future[Outcome], Task]] = {}
    call = uuid.uuid4().hex[:8]
    for number, chain in enumerate(chains):
        before: list[Future[Outcome]] = []
        for task in chain.missing:
            name = f"{task.kind}-{task.key}"
            if name not in futures:
                # Chains are finished one after the other, so that there are results early.
                future = client.submit(perform, task, *before, key=f"{name}-{call}", pure=False, priority=-number)
                futures[name] = (future, task)
            before = [futures[name][0]]
    return dict(futures.values())


def _gathered(futures: Futures, progress: Progress, on_outcome: Callable[[Outcome], None]) -> list[Outcome]:
    outcomes = []
    for future in as_completed(futures):
        try:
            outcome = future.result()
        except KilledWorker:
            outcome = Outcome(futures[future], False, "its worker, or that of what it needs, died each time that it was tried")
        except (FutureCancelledError, OSError) as problem:
            raise SchedulerLost(str(problem)) from None
        except Exception as problem:  # of the engine: the task's own are in its outcome
            outcome = Outcome(futures[future], False, f"{type(problem).__name__}: {problem}")
        outcomes.append(outcome)
        progress.add(outcome)
        progress.tell()
        on_outcome(outcome)
    return outcomes


def _to_time(chains: list[Chain]) -> dict[str, Chain]:
    """The runs whose times are wanted, each once."""
    return {chain.time.key: chain for chain in chains if not is_whole(chain.time.place)}


def _time_alone(client: Client, chains: list[Chain], progress: Progress) -> list[Outcome]:
    """One run after the other, with nothing beside it, of those whose replay succeeds; on whichever worker is there."""
    outcomes = []
    for chain in _to_time(chains).values():
        replay = chain.task("replay")
        if replay is None or not is_whole(replay.place):
            progress.todo["time"] -= 1
            continue
        before: list[Future[Outcome]] = []
        futures: Futures = {}
        for task in (*chain.missing_sequence, chain.time):  # a sequence that was deleted is made again first
            future = client.submit(perform, task, *before, key=f"{task.kind}-{task.key}-{uuid.uuid4().hex[:8]}", pure=False)
            before, futures = [future], futures | {future: task}
        outcomes += _gathered(futures, progress, lambda outcome: None)
    return outcomes


def _wait_for_a_worker(client: Client) -> None:
    """A cluster's queue may be long: waits for as long as it takes, and says so."""
    while not client.scheduler_info()["workers"]:
        try:
            client.wait_for_workers(1, timeout=60)
        except (TimeoutError, OSError):
            if client.status != "running":
                raise SchedulerLost("it went away while a worker was waited for") from None
            print("campaign: no worker yet, still waiting", file=sys.stderr, flush=True)


def execute(
    client: Client, chains: list[Chain], out: pathlib.Path, time_alone: bool, on_outcome: Callable[[Outcome], None] = lambda outcome: None
) -> list[Outcome]:
    """Does all that is missing. @return what was done, failures among it; also written to failures.json."""
    _wait_for_a_worker(client)
    count = len(client.scheduler_info()["workers"])
    futures = _submit(client, chains)
    wanted = collections.Counter(task.kind for task in futures.values())
    if time_alone:
        wanted["time"] = len(_to_time(chains))
    progress = Progress({kind: wanted[kind] for kind in KINDS if wanted[kind]}, count)
    outcomes = _gathered(futures, progress, on_outcome)
    if futures:
        _note_session(out, count, time.monotonic() - progress.start_s, outcomes)
    if time_alone:
        outcomes += _time_alone(client, chains, progress)
    progress.tell(last=True)
    failures = [
        {"kind": one.task.kind, "name": one.task.name, "why": one.why, "log": str(one.task.log) if one.task.log.exists() else None}
        for one in outcomes
        if not one.ok
    ]
    write_whole(out / FAILURES_FILE, json.dumps(failures, indent=1) + "\n", ours=True)
    return outcomes


def _note_session(out: pathlib.Path, workers: int, wall_s: float, outcomes: list[Outcome]) -> None:
    """How well the workers were used: a line a session, for the report."""
    kinds = collections.Counter(one.task.kind for one in outcomes)
    line = {
        "workers": workers,
        "wall_s": wall_s,
        "task_wall_s": sum(one.wall_s for one in outcomes),
        "task_cpu_s": sum(one.cpu_s for one in outcomes),
        "tasks": dict(kinds),
        "ended": time.strftime("%Y-%m-%d %H:%M:%S"),
    }
    with open(out / SESSIONS_FILE, "a") as stream:
        stream.write(json.dumps(line) + "\n")
