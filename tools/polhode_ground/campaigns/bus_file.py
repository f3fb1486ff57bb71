"""The packets of a run's bus.ccsds, by the project's own client."""

import pathlib
from collections.abc import Iterator
from typing import Any

import numpy as np


def packets_of(bus_file: pathlib.Path, name: str) -> Iterator[Any]:
    """Those of one name, in order; none where there is no such file."""
    if not bus_file.exists():
        return
    from polhode_bus import open_bus

    with open_bus(f"file:{bus_file}") as bus:
        yield from (packet for packet in bus.packets(timeout_s=0.0) if packet.name == name)


def pose_covariance(upper: list[float]) -> np.ndarray:
    """[6,6] of (phi, dp) from its upper triangle by rows, as packets have it."""
    full = np.zeros((6, 6))
    full[np.triu_indices(6)] = upper
    return full + np.triu(full, 1).T
