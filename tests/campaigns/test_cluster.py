"""Workers that are not this process's own: a scheduler by address, which may die, and SLURM, of which a small stand-in is here."""

import os
import pathlib
import subprocess
import sys
import time

import pytest
from polhode_ground.common.venv import REPOSITORY

PROGRAM = REPOSITORY / "build/release/bin/polhode"
SAMPLE = REPOSITORY / "hil/data/sample"
RUNS = 6
PLAN = 'sequences = ["hil/data/sample"]\nuntransformed = false\n[judge]\nshape = false\ntime_alone = false\n' + "".join(
    f'[[transforms]]\nname = "few_{seed}"\nseed = {seed}\nsteps = [{{ kind = "missing", fraction = 0.8 }}]\n' for seed in range(RUNS))

pytestmark = [pytest.mark.slow, pytest.mark.further, pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")]


def campaign(tmp_path, *more) -> list[str]:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    return [sys.executable, str(REPOSITORY / "hil/campaign.py"), str(plan), "--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache"), *more]


@pytest.fixture
def dask_cluster(tmp_path):
    """(scheduler's process, its address) with two workers, as somebody else has started them."""
    log = open(tmp_path / "cluster.log", "w")
    file = tmp_path / "scheduler.json"
    scheduler = subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", file],
                                 stdout=log, stderr=log)
    workers = [subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", file, "--nthreads", "1", "--no-dashboard",
                                 "--death-timeout", "20", "--local-directory", tmp_path / "dask"], stdout=log, stderr=log)
               for _ in range(2)]
    until = time.monotonic() + 30
    while not file.exists() or not file.read_text():
        assert time.monotonic() < until, (tmp_path / "cluster.log").read_text()
        time.sleep(0.1)
    import json
    yield scheduler, json.loads(file.read_text())["address"]
    for process in (*workers, scheduler):
        process.kill()
        process.wait()
    log.close()


def test_a_scheduler_by_address_does_the_work(tmp_path, dask_cluster):
    done = subprocess.run(campaign(tmp_path, "--scheduler", dask_cluster[1]), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and f"judge {RUNS}/{RUNS}" in done.stderr, done.stderr
    assert dask_cluster[0].poll() is None, "it is somebody else's and goes on"


def test_a_scheduler_that_dies_loses_nothing_that_was_done(tmp_path, dask_cluster):
    scheduler, address = dask_cluster
    process = subprocess.Popen(campaign(tmp_path, "--scheduler", address), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    results = tmp_path / "out/results"
    until = time.monotonic() + 120
    while not results.is_dir() or sum(not path.name.startswith(".") for path in results.iterdir()) < 2:
        assert time.monotonic() < until and process.poll() is None
        time.sleep(0.02)
    scheduler.kill()
    _, said = process.communicate(timeout=120)
    assert process.returncode == 1 and "the scheduler is gone" in said and "Traceback" not in said, said
    before = {path.name: path.stat().st_mtime_ns for path in results.iterdir() if ".part-" not in path.name and not path.name.startswith(".")}
    assert len(before) >= 2
    done = subprocess.run(campaign(tmp_path, "--workers", "2"), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    after = {path.name: path.stat().st_mtime_ns for path in results.iterdir() if not path.name.startswith(".")}
    assert len(after) == RUNS and {name: after[name] for name in before} == before


def test_no_scheduler_at_the_address_is_told(tmp_path):
    done = subprocess.run(campaign(tmp_path, "--scheduler", "tcp://127.0.0.1:1"), capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and "no scheduler answers there" in done.stderr and "Traceback" not in done.stderr


def test_slurm_jobs_do_the_work(tmp_path):
    """sbatch and scancel of this test run and end job scripts here, as SLURM would on its nodes."""
    bin_folder = tmp_path / "bin"
    bin_folder.mkdir()
    (bin_folder / "sbatch").write_text(f'#!/bin/sh\ncp "$1" {tmp_path}/job_script\nsetsid sh {tmp_path}/job_script > {tmp_path}/job.log 2>&1 &\necho $!\n')
    (bin_folder / "scancel").write_text('#!/bin/sh\nfor id; do kill -- -"$id" 2>/dev/null; done\nexit 0\n')
    for file in bin_folder.iterdir():
        file.chmod(0o755)
    example = (REPOSITORY / "hil/campaigns/slurm_example.toml").read_text()
    filled = tmp_path / "slurm.toml"
    filled.write_text(example.replace("jobs = 20", "jobs = 1").replace('queue = "FILL_IN"', 'queue = "nodes"').replace('account = "FILL_IN"', 'account = "debris"'))
    done = subprocess.run(campaign(tmp_path, "--slurm", str(filled)), capture_output=True, text=True, timeout=300,
                          env={**os.environ, "PATH": f"{bin_folder}:{os.environ['PATH']}"})
    log = tmp_path / "job.log"
    assert done.returncode == 0 and f"judge {RUNS}/{RUNS}" in done.stderr, done.stderr + (log.read_text() if log.exists() else "")
    script = (tmp_path / "job_script").read_text()
    assert "#SBATCH -p nodes" in script and "#SBATCH -A debris" in script and "PYTHONPATH" not in script


@pytest.mark.parametrize(("text", "says"), [("jobs = 1\n", "allowed are jobs, a whole number, and a table [cluster]"),
                                            ('jobs = 1\n[cluster]\ncores = 1\nmemory = "1GB"\nqueues = "x"\n', "queues")])
def test_a_slurm_file_that_is_none_is_refused(tmp_path, text, says):
    path = pathlib.Path(tmp_path / "slurm.toml")
    path.write_text(text)
    done = subprocess.run(campaign(tmp_path, "--slurm", str(path)), capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and says in done.stderr and "Traceback" not in done.stderr, done.stderr
