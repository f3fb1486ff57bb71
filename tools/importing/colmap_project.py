"""A COLMAP project: pictures and the camera that COLMAP found for them. Its poses are left out."""

import json
import pathlib
import subprocess
from collections import Counter

from importing.folder import times_of
from importing.lens import FISHEYE, RADTAN, Lens, lens_of
from importing.pictures import natural_order
from importing.source import Account, Frame, Options, Source

from judge.colmap import ensure_venv
from judge.errors import BadInput

WORKER = pathlib.Path(__file__).with_name("colmap_project_worker.py")
# COLMAP's models by where their parameters stand: (model here, focal lengths, where the distortion begins, its length here).
MODELS = {"SIMPLE_PINHOLE": (RADTAN, 1, 3, 4), "PINHOLE": (RADTAN, 2, 4, 4), "SIMPLE_RADIAL": (RADTAN, 1, 3, 4),
          "RADIAL": (RADTAN, 1, 3, 4), "OPENCV": (RADTAN, 2, 4, 4), "FULL_OPENCV": (RADTAN, 2, 4, 8), "OPENCV_FISHEYE": (FISHEYE, 2, 4, 4),
          "SIMPLE_RADIAL_FISHEYE": (FISHEYE, 1, 3, 4), "RADIAL_FISHEYE": (FISHEYE, 1, 3, 4)}
PLACES = ("", "sparse/0", "sparse", "0", "dense/sparse")  # of cameras and images below a project's folder


def model_folder(path: pathlib.Path) -> pathlib.Path | None:
    """Where the project's cameras.bin or cameras.txt is; None where there is none."""
    return next((path / place for place in PLACES for suffix in ("bin", "txt")
                 if (path / place / f"cameras.{suffix}").is_file() and (path / place / f"images.{suffix}").is_file()), None)


def lens_of_camera(camera: dict, where: str) -> Lens:
    """COLMAP's pixel centres lie at + 0.5, ours at integers."""
    if camera["model"] not in MODELS:
        raise BadInput(f"{where}: camera model {camera['model']}, allowed are {', '.join(MODELS)}; undistort by COLMAP first")
    model, focals, begin, length = MODELS[camera["model"]]
    params = camera["params"]
    fu, fv = params[0], params[focals - 1]
    centre = params[focals] - 0.5, params[focals + 1] - 0.5
    distortion = [*params[begin:], *[0.0] * length][:length]
    return lens_of(camera["width"], camera["height"], (fu, fv, *centre), model, distortion, where)


def open_colmap(path: pathlib.Path, options: Options) -> Source:
    folder = model_folder(path)
    done = subprocess.run([ensure_venv(), WORKER, folder], capture_output=True, text=True)
    if done.returncode != 0:
        raise BadInput(f"{folder}: pycolmap can't read it: {' '.join(done.stderr.strip().splitlines()[-1:])}")
    project = json.loads(done.stdout.strip().splitlines()[-1])
    if not project["images"]:
        raise BadInput(f"{folder}: a COLMAP model without pictures")
    account = Account()
    number, count = Counter(image["camera"] for image in project["images"]).most_common(1)[0]
    others = len(project["images"]) - count
    if others:
        account.dropped["taken by another camera of the project"] += others
    names = [image["name"] for image in project["images"] if image["camera"] == number]
    root = _picture_folder(path, folder, names)
    files = sorted((root / name for name in names), key=natural_order)
    times_ns, nominal, said = times_of(files, options.rate_hz)
    account.assumed += [said, "COLMAP's poses are left out: Polhode finds its own"]
    lens = lens_of_camera(project["cameras"][number], str(folder))
    frames = (Frame(time_ns, file=file) for file, time_ns in sorted(zip(files, times_ns), key=lambda pair: pair[1]))
    return Source(f"COLMAP project, {count} pictures, camera {project['cameras'][number]['model']}", frames, account, count, lens,
                  f"the project's camera {number}", nominal)


def _picture_folder(path: pathlib.Path, model: pathlib.Path, names: list[str]) -> pathlib.Path:
    for root in (path / "images", path, model.parent / "images", model.parent.parent / "images", model / "images"):
        if (root / names[0]).is_file():
            missing = [name for name in names if not (root / name).is_file()]
            if missing:
                raise BadInput(f"{root}: {missing[0]} is missing, {len(missing)} of {len(names)} pictures of the project")
            return root
    raise BadInput(f"{path}: the project's pictures ({names[0]}, ...) are not there; expected in {path / 'images'}")
