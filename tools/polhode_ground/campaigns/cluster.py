"""Where tasks run: workers of this machine, a Dask scheduler by address, or SLURM."""

import contextlib
import logging
import pathlib
import tomllib
from collections.abc import Iterator

import dask
from distributed import Client, LocalCluster

from polhode_ground.common.errors import BadInput

# Times that a worker may die at a task before the task is given up.
DEATHS_MAX = 3
SETTINGS = {
    "distributed.scheduler.allowed-failures": DEATHS_MAX,
    "distributed.comm.timeouts.connect": "20s",
    "distributed.comm.retry.count": 2,
    # A replay's memory is planned and checked by itself; a worker's own is small.
    "distributed.worker.memory.terminate": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.target": False,
}


def _local(workers: int) -> Client:
    return Client(
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",
            memory_limit=None,
            silence_logs=logging.CRITICAL,
        )
    )


def _at(address: str) -> Client:
    try:
        return Client(address, timeout="20s")
    except (OSError, ValueError, TypeError) as problem:
        raise BadInput(f"--scheduler {address}: no scheduler answers there: {problem}") from None


def _slurm(file: pathlib.Path) -> Client:
    """file: table [cluster] with the keywords of dask_jobqueue.SLURMCluster, and how many jobs."""
    from dask_jobqueue import SLURMCluster

    try:
        table = tomllib.loads(file.read_text())
    except OSError as problem:
        raise BadInput(f"--slurm {file}: {problem.strerror}") from None
    except tomllib.TOMLDecodeError as problem:
        raise BadInput(f"--slurm {file}: not TOML: {problem}") from None
    if set(table) != {"jobs", "cluster"} or not isinstance(table["jobs"], int) or not isinstance(table["cluster"], dict):
        raise BadInput(f"--slurm {file}: allowed are jobs, a whole number, and a table [cluster]")
    try:
        cluster = SLURMCluster(scheduler_options={"dashboard_address": ":0"}, **table["cluster"])
    except (TypeError, ValueError) as problem:
        raise BadInput(f"--slurm {file}: {problem}") from None
    cluster.scale(jobs=table["jobs"])
    return Client(cluster)


@contextlib.contextmanager
def workers(count: int, scheduler: str | None, slurm: pathlib.Path | None) -> Iterator[Client]:
    """A client of the workers; they end with it, unless they belong to a scheduler that was there."""
    for name in [name for name in logging.root.manager.loggerDict if name.split(".")[0] == "distributed"]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what is lost is told by us, in a line
    with dask.config.set(SETTINGS):
        client = _at(scheduler) if scheduler else _slurm(slurm) if slurm else _local(count)
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):  # a scheduler that is gone can't be told
                client.close(timeout=5)
                if not scheduler and client.cluster is not None:
                    client.cluster.close(timeout=5)
