"""What workers do: render a scene, draw a path, transform a sequence, replay it, judge the run, ask for its limit, time a run alone.

A task is plain data; its result is a folder, which is there whole or not at all, so a task that is done is done for good.
A task never raises: what went wrong is told in its outcome, with a log, and whatever needs its result is not tried.
"""

import contextlib
import errno
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import traceback
from dataclasses import dataclass, field
from typing import Any

from polhode_ground.campaigns import store
from polhode_ground.common.errors import BadInput
from polhode_ground.common.replay import APART
from polhode_ground.common.venv import REPOSITORY

RENDER_TIMEOUT_S = 24 * 3600.0
# A worker that is killed takes what it started with it. A parent's death is told to its own children only, so each is told.
TOGETHER = ("setpriv", "--pdeathsig", "KILL", "--")


@dataclass(frozen=True)
class Task:
    """One thing to make: `place` is where it will be, `log` where is told what went wrong."""

    kind: str
    key: str
    name: str
    place: pathlib.Path
    log: pathlib.Path
    options: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    task: Task
    ok: bool
    why: str = ""  # one line, where it is not ok
    not_tried: bool = False  # since something that it needs failed
    wall_s: float = 0.0
    cpu_s: float = 0.0  # of this process and of those that it started


class Failed(Exception):
    """A task's result can't be made; the text is one line."""


def run_program(words: list[Any], log: pathlib.Path, timeout_s: float, lock: int) -> None:
    """Runs a program to its end, what it says goes to the log; Failed with its last line where it fails."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with open(log, "w") as stream:
        process = subprocess.Popen(
            [*TOGETHER, *APART, *TOGETHER, *map(str, words)],
            stdout=stream,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            pass_fds=(lock,),
            start_new_session=True,
        )
        try:
            status = process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            raise Failed(f"took more than {timeout_s:.0f} s") from None
    if status != 0:
        lines = log.read_text(errors="replace").strip().splitlines()
        raise Failed(f"ended with status {status}: {lines[-1] if lines else 'it said nothing'}")
    log.unlink()


def _render(task: Task, lock: int) -> None:
    """Renders in place: an interrupted rendering goes on where it stopped, if it has got as far as saying what it is."""
    try:
        json.loads((task.place / "scene.json").read_text())
    except (OSError, ValueError):
        shutil.rmtree(task.place, ignore_errors=True)
    words = [REPOSITORY / "hil/render_scene.sh", task.options["file"], task.place, "--threads", 1]
    if task.options["variant"]:
        words += ["--variant", task.options["variant"]]
    run_program(words, task.log, RENDER_TIMEOUT_S, lock)


def _draw(task: Task, lock: int) -> None:
    from polhode_ground.paths.draw import draw_path

    shutil.rmtree(task.place, ignore_errors=True)  # what an interrupted worker left
    draw_path([task.options["seed"], task.options["number"]], task.options["frames"], tuple(task.options["resolution"]), task.place)


def _transform(task: Task, lock: int) -> None:
    from polhode_ground.transforms.table import transform

    with store.appearing(task.place) as part:
        transform(pathlib.Path(task.options["source"]), part / "made", task.options["steps"], task.options["seed"])
        for made in (part / "made").iterdir():
            made.rename(part / made.name)
        (part / "made").rmdir()


def _replay_words(task: Task, out: pathlib.Path) -> list[Any]:
    words = [
        task.options["program"],
        "replay",
        "--config",
        task.options["config"],
        "--sequence",
        task.options["sequence"],
        "--out",
        out,
        "--one-core",
    ]
    return words + [word for setting in task.options["settings"] for word in ("--set", setting)]


def _replay(task: Task, lock: int) -> None:
    with store.appearing(task.place) as part:
        run_program(_replay_words(task, part), task.log, task.options["timeout_s"], lock)


def _judge(task: Task, lock: int) -> None:
    from polhode_ground.campaigns.measures import measure, write_result

    row, frames = measure(pathlib.Path(task.options["run"]), pathlib.Path(task.options["sequence"]), shape=task.options["shape"])
    with store.appearing(task.place) as part:
        write_result(row, frames, part)


def _time(task: Task, lock: int) -> None:
    """Replays again, with nothing beside it, and keeps only what it cost."""
    with store.appearing(task.place) as part:
        run_program(_replay_words(task, part / "run"), task.log, task.options["timeout_s"], lock)
        summary = json.loads((part / "run/summary.json").read_text())
        shutil.rmtree(part / "run")
        frames, step = summary["frames"]["in"], summary["timings"]["step"]
        (part / "time.json").write_text(
            json.dumps(
                {
                    "cpu_ms_a_frame": 1e3 * summary["cost"]["cpu_s"] / frames,
                    "step_cpu_median_ms": step["cpu_p50_us"] / 1e3,
                    "step_cpu_longest_ms": step["cpu_max_us"] / 1e3,
                    "step_wall_longest_ms": step["max_us"] / 1e3,
                    "peak_resident_mb": summary["memory"]["peak_resident_octets"] / 1e6,
                }
            )
        )


def _limit(task: Task, lock: int) -> None:
    """From which frame on the images could decide on the depth sign, by the truth."""
    with store.appearing(task.place) as part:
        words = [
            task.options["program"],
            "--config",
            task.options["config"],
            "--sequence",
            task.options["sequence"],
            "--json",
            part / "limit.json",
        ]
        run_program(
            words + [word for setting in task.options["settings"] for word in ("--set", setting)], task.log, task.options["timeout_s"], lock
        )


def _same_sources(task: Task) -> None:
    """A result is named by the code that makes it: code that has changed meanwhile must not make it."""
    patterns, expected = task.options.get("sources", ((), None))
    if expected is not None and store.source_digest(*patterns) != expected:
        raise Failed("the project's own sources have changed since the campaign began: run it again")


MAKERS = {"render": _render, "draw": _draw, "transform": _transform, "replay": _replay, "judge": _judge, "limit": _limit, "time": _time}
KINDS = tuple(MAKERS)  # in the order in which they follow each other


def _cpu_s() -> float:
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def _why(problem: BaseException, task: Task) -> str:
    if isinstance(problem, (Failed, BadInput)):
        return str(problem)
    if isinstance(problem, OSError) and problem.errno == errno.ENOSPC:
        return f"the disk is full: {problem.filename or task.place}"
    with contextlib.suppress(OSError):
        task.log.parent.mkdir(parents=True, exist_ok=True)
        task.log.write_text(traceback.format_exc())
    return f"{type(problem).__name__}: {problem}"


def perform(task: Task, *needed: Outcome) -> Outcome:
    """Makes a task's result, unless it is there, or something that it needs could not be made."""
    missing = next((one for one in needed if not one.ok), None)
    if missing is not None:
        return Outcome(task, False, f"not tried: {missing.task.kind} of {missing.task.name} failed", not_tried=True)
    start_s, start_cpu_s = time.monotonic(), _cpu_s()
    try:
        task.place.parent.mkdir(parents=True, exist_ok=True)
        with store.locked(task.place) as lock:
            if not store.is_whole(task.place):
                _same_sources(task)
                MAKERS[task.kind](task, lock)
    except Exception as problem:  # whatever it is, the others go on
        return Outcome(task, False, _why(problem, task), wall_s=time.monotonic() - start_s, cpu_s=_cpu_s() - start_cpu_s)
    return Outcome(task, True, wall_s=time.monotonic() - start_s, cpu_s=_cpu_s() - start_cpu_s)
