"""A live run of the program on a played sequence."""

import os
import pathlib
import signal
import subprocess
import time
import types

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]



def pytest_collection_modifyitems(config, items):
    here = pathlib.Path(__file__).parent
    if not PROGRAM.exists():
        for item in items:
            if here in item.path.parents:
                item.add_marker(pytest.mark.skip(reason=f"{PROGRAM} is not built"))


@pytest.fixture
def played(tmp_path):
    """Twelve frames of 160x120, 0.1 s apart; the body changes its face every third."""
    writer = SequenceWriter(tmp_path / "played")
    for seed in range(12):
        writer.add(textured(seed // 3))
    return writer


def toml(value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f'"{value}"' if isinstance(value, (str, pathlib.Path)) else str(value)


@pytest.fixture
def live(tmp_path):
    """Writes a configuration and starts `polhode run`. Keyword arguments are keys with __ for the dot.
    @return the process, with `folder` and `finish()` -> status, err."""
    started = []

    def start(source, name="run", settings=(), env=None, memory_trap=False, **options):
        folder = tmp_path / name
        keys = {"device__source": source, "device__sequence_speed": 0.0, "run__folder": folder, **options}
        config = tmp_path / f"{name}.toml"
        sections: dict[str, list[str]] = {}
        for key, value in keys.items():
            section, field = key.split("__")
            sections.setdefault(section, []).append(f"{field} = {toml(value)}")
        config.write_text("\n".join(line for section, lines in sections.items() for line in (f"[{section}]", *lines)) + "\n")
        command = [PROGRAM, "run", "--config", config, *(["--memory-trap"] if memory_trap else [])]
        for setting in settings:
            command += ["--set", setting]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                   env={**os.environ, **(env or {})})
        started.append(process)

        def finish(timeout_s=300):
            _, err = process.communicate(timeout=timeout_s)
            return types.SimpleNamespace(status=process.returncode, err=err)

        return types.SimpleNamespace(process=process, folder=folder, finish=finish)

    yield start
    for process in started:
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
            process.wait()


@pytest.fixture
def replayed(tmp_path):
    """The bus bytes of a replay."""

    def call(sequence, *arguments, config=DEFAULTS, name="replayed"):
        out = tmp_path / name
        subprocess.run([PROGRAM, "replay", "--config", config, "--sequence", sequence, "--out", out, *arguments],
                       check=True, capture_output=True, timeout=300)
        return (out / "bus.ccsds").read_bytes()

    return call


@pytest.fixture
def until():
    """Waits for something that will be true soon."""

    def wait(condition, limit_s=60.0):
        end = time.monotonic() + limit_s
        while not condition():
            assert time.monotonic() < end, "it did not happen"
            time.sleep(0.02)

    return wait


@pytest.fixture
def program_status():
    def call(*arguments):
        done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                              cwd=PROGRAM.parents[3])
        return done.returncode, done.stderr

    return call
