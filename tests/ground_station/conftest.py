"""A YAMCS server with Polhode's configuration, in a network of its own: run by hil/test_ground_station.sh."""

import os
import pathlib
import signal
import socket
import subprocess
import time
import types
import urllib.error
import urllib.request

import pytest
from flights import damaged, flight

__all__ = ["damaged", "flight"]  # fixtures

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

TM, TC, HTTP, PAGE = 20015, 20016, 20090, 20091


def pytest_collection_modifyitems(items):
    here = pathlib.Path(__file__).parent
    for item in items:
        if here in item.path.parents and not os.environ.get("POLHODE_GROUND_STATION"):
            item.add_marker(pytest.mark.skip(reason="hil/test_ground_station.sh runs it"))


def wait_until(true, seconds: float, what: str):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if (answer := true()):
            return answer
        time.sleep(0.5)
    pytest.fail(f"{what}: not within {seconds} s")


def answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=5) as reply:
            return reply.status == 200
    except (urllib.error.URLError, OSError):
        return False


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """@return client of yamcs-client, send(octets) to the telemetry link, the key that it signs commands with."""
    from yamcs.client import YamcsClient

    folder = tmp_path_factory.mktemp("yamcs")
    ports = ["--tm", str(TM), "--tc", str(TC), "--http", str(HTTP), "--page", str(PAGE)]
    key = folder / "commands.key"
    key.touch(mode=0o600)
    key.write_text("e7" * 32 + "\n")
    with open(folder / "server.log", "w") as log:
        process = subprocess.Popen([REPOSITORY / "hil/ground_station.sh", "--data", folder / "data", "--key", key, *ports], stdout=log,
                                   stderr=subprocess.STDOUT, start_new_session=True)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        running = f"http://127.0.0.1:{HTTP}/api/instances/polhode"
        wait_until(lambda: answers(running), 240, "the server starts")
        client = YamcsClient(f"127.0.0.1:{HTTP}")
        wait_until(lambda: client.get_link("polhode", "telemetry").get_info().status == "OK", 60, "the telemetry link")
        yield types.SimpleNamespace(client=client, send=lambda octets: sender.sendto(octets, ("127.0.0.1", TM)), log=folder / "server.log",
                                    key=key)
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(timeout=30)

