"""COLMAP's own library, called in its own environment (colmap_project_worker.py)."""

import functools
import json
import pathlib
import subprocess
import tempfile

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.judge.colmap import ensure_venv

WRONG_PARAMETERS = "; a camera has more or fewer parameters than its model, or such as are no numbers with decimal points"
WORKER = pathlib.Path(__file__).with_name("colmap_project_worker.py")


@functools.cache
def python() -> pathlib.Path:
    """COLMAP's own, set up and looked after once in a run."""
    return ensure_venv()


def called(where, *arguments) -> str:
    """What the worker prints last."""
    done = subprocess.run([python(), WORKER, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        why = " ".join(done.stderr.strip().splitlines()[-1:])
        raise BadInput(f"{where}: pycolmap can't read it: {why}{WRONG_PARAMETERS if 'VerifyParams' in why else ''}")
    return done.stdout.strip().splitlines()[-1]


def read_project(folder: pathlib.Path, where: pathlib.Path | None = None) -> dict:
    """{"cameras": {number: {"model", "width", "height", "params"}}, "images": [{"name", "camera"}]}

    @param where  what messages name, where it is not the folder
    """
    return json.loads(called(where or folder, "read", folder))


def project(model: str, coefficients: tuple[float, ...], directions: np.ndarray) -> np.ndarray:
    """Places [N,2] of directions [N,3] for focal lengths of 1 and a centre of 0; NaN where the model has none."""
    with tempfile.TemporaryDirectory() as place:
        given, found = pathlib.Path(place) / "directions.npy", pathlib.Path(place) / "places.npy"
        np.save(given, directions)
        called(model, "project", model, json.dumps([1, 1, 0, 0, *coefficients]), given, found)
        return np.load(found)
