"""What is made is whole or absent, whoever dies meanwhile; what fails is told and does not stop the rest."""

import os
import pathlib
import signal
import subprocess
import sys
import textwrap
import time

import pytest
from polhode_ground.campaigns import store, tasks
from polhode_ground.campaigns.tasks import Outcome, Task


def task(tmp_path, kind="replay", name="run", **options):
    return Task(kind, "key", name, tmp_path / "runs" / "key", tmp_path / "logs" / "log", options)


def program(tmp_path, body):
    path = tmp_path / "program"
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return path


def replay_of(tmp_path, body, timeout_s=20.0):
    return task(tmp_path, program=str(program(tmp_path, body)), config="c", sequence="s", settings=["a=1"], timeout_s=timeout_s)


# $7 is what follows --out.
DONE = 'mkdir -p "$7"; echo "$@" > "$7/words"'


def test_a_result_appears_whole(tmp_path):
    one = replay_of(tmp_path, DONE)
    outcome = tasks.perform(one)
    assert outcome.ok and not one.log.exists()
    words = (one.place / "words").read_text().split()
    assert words[:3] == ["replay", "--config", "c"] and "--one-core" in words and words[-2:] == ["--set", "a=1"]
    assert [path.name for path in one.place.parent.iterdir() if not path.name.startswith(".")] == ["key"]


def test_what_is_there_is_not_made_again(tmp_path):
    one = replay_of(tmp_path, "exit 1")
    one.place.mkdir(parents=True)
    assert tasks.perform(one).ok


def test_a_failure_is_told_with_its_log_and_leaves_nothing(tmp_path):
    one = replay_of(tmp_path, 'touch "$7/half"; echo something; echo the reason >&2; exit 3')
    outcome = tasks.perform(one)
    assert not outcome.ok and outcome.why == "ended with status 3: the reason" and "something" in one.log.read_text()
    assert not [path for path in one.place.parent.iterdir() if not path.name.startswith(".")]


def test_what_needs_a_failure_is_not_tried(tmp_path):
    one = replay_of(tmp_path, DONE)
    outcome = tasks.perform(one, Outcome(task(tmp_path, "render", "scene"), False, "no"))
    assert not outcome.ok and outcome.not_tried and outcome.why == "not tried: render of scene failed" and not one.place.exists()


def test_a_program_that_hangs_is_ended(tmp_path):
    outcome = tasks.perform(replay_of(tmp_path, "sleep 60", timeout_s=0.3))
    assert outcome.why == "took more than 0 s" and outcome.wall_s < 10


def test_leftovers_of_the_dead_are_removed(tmp_path):
    one = replay_of(tmp_path, DONE)
    (one.place.parent / "key.part-dead").mkdir(parents=True)
    assert tasks.perform(one).ok and not (one.place.parent / "key.part-dead").exists()


def test_a_full_disk_is_told_and_takes_nothing_that_was_done(tmp_path):
    """A file system of 64 kB of its own, in a namespace of its own."""
    script = textwrap.dedent(f"""
        import pathlib
        from polhode_ground.campaigns import store, tasks
        place = pathlib.Path({str(tmp_path)!r}) / "small"
        tasks.MAKERS["replay"] = lambda task, lock: fill(task)
        def fill(task):
            with store.appearing(task.place) as part:
                (part / "file").write_bytes(b"x" * task.options["octets"])
        def one(key, octets):
            return tasks.perform(tasks.Task("replay", key, key, place / key, place / "log", {{"octets": octets}}))
        print(one("first", 20_000).ok, one("second", 100_000).why, one("third", 10_000).ok, sorted(p.name for p in place.iterdir() if p.name[0] != "."))
        """)
    (tmp_path / "small").mkdir()
    (tmp_path / "script.py").write_text(script)
    done = subprocess.run(["unshare", "--mount", "--map-root-user", "sh", "-c",
                           f"mount -t tmpfs -o size=64k none {tmp_path}/small && exec {sys.executable} {tmp_path}/script.py"],
                          capture_output=True, text=True, timeout=60)
    if "unshare failed" in done.stderr or "permission denied" in done.stderr or "must be superuser" in done.stderr:
        pytest.skip("this machine lets nobody mount a file system of his own")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("True the disk is full") and done.stdout.endswith("True ['first', 'third']\n"), done.stdout


def test_a_killed_worker_takes_its_programs_with_it(tmp_path):
    marker = f"{os.getpid()}.25"
    one = replay_of(tmp_path, f"exec sleep {marker}")
    script = ("import pathlib\nfrom polhode_ground.campaigns import tasks\n"
              f"P = pathlib.Path\ntasks.perform(tasks.{one!r})").replace("PosixPath", "P")
    worker = subprocess.Popen([sys.executable, "-c", script])

    def sleeping():
        words = f"sleep\0{marker}\0".encode()
        return any(words == read(path) for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"))

    def read(path):
        try:
            return path.read_bytes()
        except OSError:  # it has ended meanwhile
            return b""

    def wait_for(state):
        until = time.monotonic() + 20
        while sleeping() != state and time.monotonic() < until:
            time.sleep(0.05)
        return sleeping() == state

    assert wait_for(True), "it has started its program"
    worker.send_signal(signal.SIGKILL)
    worker.wait()
    assert wait_for(False)
    (tmp_path / "program").write_text(f"#!/bin/sh\n{DONE}\n")
    assert tasks.perform(one).ok, "nobody holds the lock"


def test_a_key_holds_every_part_and_its_place():
    assert store.digest("a", "b") != store.digest("ab") != store.digest("b", "a")
    assert store.digest({"x": 1, "y": 2}) == store.digest({"y": 2, "x": 1})


def test_a_rendering_that_was_hardly_begun_begins_anew(tmp_path, monkeypatch):
    place = tmp_path / "scenes" / "key"
    one = Task("render", "key", "scene", place, tmp_path / "log", {"file": "scene.toml", "variant": ""})
    found = []

    def render(words, log, timeout_s, lock):
        found.append(sorted(path.name for path in place.iterdir()) if place.is_dir() else None)
        (place / "mav0/cam0").mkdir(parents=True, exist_ok=True)
        (place / "mav0/cam0/data.csv").write_text("")

    monkeypatch.setattr(tasks, "run_program", render)
    place.mkdir(parents=True)
    (place / "truth.csv").write_text("left by one that was killed")
    assert not store.is_whole(place) and tasks.perform(one).ok and found == [None]
    (place / "mav0/cam0/data.csv").unlink()
    (place / "scene.json").write_text('{"fing')  # a full disk
    assert tasks.perform(one).ok and found == [None, None]
    (place / "mav0/cam0/data.csv").unlink()
    (place / "scene.json").write_text("{}")
    assert tasks.perform(one).ok and found[-1] == ["mav0", "scene.json"], "one that says what it is goes on"


def test_code_that_has_changed_meanwhile_makes_nothing(tmp_path):
    one = Task("judge", "key", "run", tmp_path / "results/key", tmp_path / "log", {"sources": (("README.md",), "another digest")})
    outcome = tasks.perform(one)
    assert not outcome.ok and "sources have changed" in outcome.why and not one.place.exists()
