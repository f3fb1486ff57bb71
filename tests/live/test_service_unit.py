"""The unit file, as far as it can be held to without a running systemd: it is well formed, grants what the live run asks for, and the run
keeps within its limits."""

import pathlib
import re
import resource
import shutil
import subprocess

import pytest
from polhode_ground.testing.replay_files import PROGRAM, REPOSITORY

UNIT = REPOSITORY / "platform/systemd/polhode.service"

pytestmark = pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="systemd-analyze is not installed")


def settings(key: str) -> list[str]:
    return [line.split("=", 1)[1] for line in UNIT.read_text().splitlines() if line.startswith(f"{key}=")]


def analyze(*arguments) -> subprocess.CompletedProcess:
    return subprocess.run(["systemd-analyze", *arguments], capture_output=True, text=True)


def calls_of(group: str) -> set[str]:
    """Names of system calls in a systemd group, groups within it too; a name stands for itself."""
    if not group.startswith("@"):
        return {group}
    lines = analyze("syscall-filter", group).stdout.splitlines()
    names = [line.strip() for line in lines[1:] if line.strip() and not line.strip().startswith("#")]
    return set().union(*(calls_of(name) for name in names))


def allowed_calls() -> set[str]:
    allowed: set[str] = set()
    for line in settings("SystemCallFilter"):
        for group in line.lstrip("~").split():
            allowed = allowed - calls_of(group) if line.startswith("~") else allowed | calls_of(group)
    return allowed


@pytest.fixture
def unit(tmp_path) -> pathlib.Path:
    """With the program where it is built: systemd-analyze wants to find it."""
    file = tmp_path / "polhode.service"
    file.write_text(UNIT.read_text().replace("/usr/bin/polhode", str(PROGRAM)))
    return file


def test_systemd_takes_it(unit):
    verified = analyze("verify", unit)
    assert verified.returncode == 0 and "polhode.service" not in verified.stderr, verified.stderr


# verifies: LIV-12
def test_its_exposure_stays_low(unit):
    rated = analyze("security", "--offline=true", "--threshold=20", unit)  # of 100, in tenths of what it prints
    assert rated.returncode == 0, rated.stdout.splitlines()[-1:]


# verifies: LIV-12
@pytest.mark.skipif(not shutil.which("strace"), reason="strace is not installed")
def test_a_run_asks_for_nothing_that_it_forbids(played, tmp_path):
    """All that a run can do at once: transports of each kind, commands, checkpoints, a recording, priority, locked memory."""
    key = tmp_path / "key"
    key.write_text("5a" * 32)
    key.chmod(0o600)
    config = tmp_path / "live.toml"
    config.write_text(f"""
[device]
source = "{played.path}"
sequence_speed = 0.0
[run]
folder = "{tmp_path}/run"
checkpoint = "{tmp_path}/run/checkpoint"
checkpoint_frames = 3
core = 0
priority = 10
[recording]
folder = "{tmp_path}/recording"
[transport]
send = ["unix:{tmp_path}/telemetry", "udp:127.0.0.1:40124", "shm:/polhode_unit_test", "file:{tmp_path}/stream"]
receive = ["unix:{tmp_path}/commands", "udp:40125"]
[commands]
key = "{key}"
window = "{tmp_path}/run/commands.window"
""")
    files_max = int(settings("LimitNOFILE")[0])
    trace = tmp_path / "trace"
    try:
        done = subprocess.run(["strace", "-f", "-qq", "-o", trace, PROGRAM, "run", "--config", config], capture_output=True, text=True,
                              timeout=300, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files_max, files_max)))
    finally:
        pathlib.Path("/dev/shm/polhode_unit_test").unlink(missing_ok=True)
    assert done.returncode == 0, done.stderr
    lines = trace.read_text().splitlines()
    called = {match[1] for line in lines if (match := re.match(r"\d+ +(?:<\.\.\. )?(\w+)(?:\(| resumed)", line))}
    assert {"openat", "mlockall", "sched_setscheduler", "sched_setaffinity", "futex"} <= called
    assert called <= allowed_calls(), called - allowed_calls()
    processes = {line.split()[0] for line in lines}
    assert len(processes) <= int(settings("TasksMax")[0])
    writable_code = [line for line in lines if "PROT_WRITE" in line and "PROT_EXEC" in line]
    assert not writable_code, writable_code
