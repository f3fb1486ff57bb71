"""Same input, same bytes: the bus stream depends on frames, configuration and commands, and on nothing else."""

import multiprocessing
import os
import random
import signal
import subprocess
import time

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM, summary
from polhode_ground.testing.sequence_writer import SequenceWriter, textured


@pytest.fixture(scope="session")
def excerpt(sample, tmp_path_factory):
    """The sample up to where its map has grown over half a turn."""
    folder = tmp_path_factory.mktemp("excerpt")
    (folder / "mav0/cam0").mkdir(parents=True)
    for name in ("data", "sensor.yaml"):
        (folder / "mav0/cam0" / name).symlink_to(sample / "mav0/cam0" / name)
    lines = (sample / "mav0/cam0/data.csv").read_text().splitlines()
    (folder / "mav0/cam0/data.csv").write_text("\n".join(lines[:45]) + "\n")
    return folder


@pytest.fixture(params=["short", pytest.param("excerpt", marks=pytest.mark.further)])
def subject(request, tmp_path):
    if request.param == "excerpt":
        return request.getfixturevalue("excerpt")
    writer = SequenceWriter(tmp_path / "short")
    for seed in range(12):
        writer.add(textured(seed // 4))
    return writer.path


@pytest.fixture(scope="session")
def excerpt_run(program, excerpt, tmp_path_factory):
    folder = tmp_path_factory.mktemp("excerpt_run") / "out"
    result = program("replay", "--config", DEFAULTS, "--sequence", excerpt, "--out", folder)
    result.folder = folder
    return result


@pytest.fixture
def first(request, replay, subject, tmp_path):
    """The replay of `subject` that others are compared with."""
    is_excerpt = request.node.callspec.params["subject"] == "excerpt"
    return request.getfixturevalue("excerpt_run") if is_excerpt else replay(subject, out=tmp_path / "first")


def spin():
    while True:
        pass


def hash_of(result):
    assert result.status == 0, result.err
    return summary(result.folder)["bus_sha256"]


# verifies: CMP-01
def test_two_replays_give_the_same_bytes(replay, sample_run, tmp_path):
    second = replay(sample_run.sequence, out=tmp_path / "second")
    assert hash_of(sample_run) == hash_of(second)
    for name in ("bus.ccsds", "observations.csv", "motion_smoothed.csv", "cloud.ply", "shape.json", "motion_model.json"):
        assert (sample_run.folder / name).read_bytes() == (second.folder / name).read_bytes(), name


# verifies: CMP-01
def test_on_a_loaded_machine(replay, subject, first, tmp_path):
    """Twice as many busy processes as cores."""
    busy = [multiprocessing.Process(target=spin, daemon=True) for _ in range(2 * os.cpu_count())]
    try:
        for process in busy:
            process.start()
        assert hash_of(replay(subject, out=tmp_path / "loaded")) == hash_of(first)
    finally:
        for process in busy:
            process.kill()


@pytest.mark.parametrize("subject", ["short"], indirect=True)
def test_at_the_pace_of_the_time_stamps(replay, subject, first, tmp_path):
    before = time.monotonic()
    paced = replay(subject, "--realtime", out=tmp_path / "paced")
    assert time.monotonic() - before >= 1.1  # 12 frames, 0.1 s apart
    assert hash_of(first) == hash_of(paced)


def test_with_files_that_come_at_uneven_speed(subject, first, tmp_path):
    """The program is halted and let go at random moments, as a slow disk would do to it."""
    halted = tmp_path / "halted"
    process = subprocess.Popen([PROGRAM, "replay", "--config", DEFAULTS, "--sequence", subject, "--out", halted],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    chance = random.Random(1)
    while process.poll() is None:
        time.sleep(chance.uniform(0.001, 0.02))
        os.kill(process.pid, signal.SIGSTOP)
        time.sleep(chance.uniform(0.0, 0.02))
        os.kill(process.pid, signal.SIGCONT)
    assert process.returncode == 0
    assert summary(halted)["bus_sha256"] == hash_of(first)


# verifies: CMP-01
@pytest.mark.parametrize("delay_frames", [1, pytest.param(4, marks=pytest.mark.further)])
def test_on_one_core_or_two_and_however_long_a_job_takes(replay, subject, tmp_path, delay_frames):
    delay = ("--set", f"jobs.delay_frames={delay_frames}")
    on_one_core = hash_of(replay(subject, *delay, "--one-core", out=tmp_path / "one"))
    for latency_ms in (0, 40):
        held = replay(subject, *delay, "--job-latency-ms", str(latency_ms), out=tmp_path / f"held_{latency_ms}")
        assert hash_of(held) == on_one_core, latency_ms


def test_another_seed_or_parameter_changes_the_hash_of_the_configuration(replay, sequence, tmp_path):
    one = replay(sequence.path, out=tmp_path / "one")
    two = replay(sequence.path, "--set", "seed=2", out=tmp_path / "two")
    assert summary(one.folder)["config_hash"] != summary(two.folder)["config_hash"]
