"""Cameras of COLMAP; its files are read by its own library."""

import pathlib
import shutil
import tempfile
from collections import Counter

import numpy as np

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.colmap_library import read_project
from polhode_ground.importing.lens import Lens, lens_of
from polhode_ground.importing.lens_models import COLMAP_MODELS, FISHEYE, FOV, PANORAMA, RADTAN, UNIFIED
from polhode_ground.importing.source import Account

# COLMAP's models by where their parameters stand: (model here, focal lengths, where the distortion begins, its length here).
MODELS = {
    "SIMPLE_PINHOLE": (RADTAN, 1, 3, 4),
    "PINHOLE": (RADTAN, 2, 4, 4),
    "SIMPLE_RADIAL": (RADTAN, 1, 3, 4),
    "RADIAL": (RADTAN, 1, 3, 4),
    "OPENCV": (RADTAN, 2, 4, 4),
    "FULL_OPENCV": (RADTAN, 2, 4, 8),
    "SIMPLE_FISHEYE": (FISHEYE, 1, 3, 4),
    "FISHEYE": (FISHEYE, 2, 4, 4),
    "SIMPLE_RADIAL_FISHEYE": (FISHEYE, 1, 3, 4),
    "RADIAL_FISHEYE": (FISHEYE, 1, 3, 4),
    "OPENCV_FISHEYE": (FISHEYE, 2, 4, 4),
    "FOV": (FOV, 2, 4, 1),
    "EUCM": (UNIFIED, 2, 4, 2),
    "SIMPLE_DIVISION": ("COLMAP's DIVISION", 1, 3, 1),
    **{name: (f"COLMAP's {name}", 2, 4, length) for name, length in COLMAP_MODELS.items()},
}


def lens_of_camera(camera: dict, where: str) -> Lens:
    """COLMAP's pixel centres lie at + 0.5, ours at integers."""
    width, height, params = camera["width"], camera["height"], camera["params"]
    if camera["model"] == "EQUIRECTANGULAR":
        return lens_of(width, height, (width / (2 * np.pi), height / np.pi, (width - 1) / 2, (height - 1) / 2), PANORAMA, (), where)
    if camera["model"] not in MODELS:
        raise BadInput(f"{where}: camera model {camera['model']}, allowed are {', '.join(MODELS)}; undistort by COLMAP first")
    model, focals, begin, length = MODELS[camera["model"]]
    fu, fv = params[0], params[focals - 1]
    centre = params[focals] - 0.5, params[focals + 1] - 0.5
    distortion = [*params[begin:], *[0.0] * length][:length]
    return lens_of(width, height, (fu, fv, *centre), model, distortion, where)


def with_one_camera(project: dict, account: Account) -> dict:
    """As it is; but where nearly every picture has a camera of its own, as COLMAP makes them unless it is told otherwise, those of one
    model and size become one."""
    cameras, images = project["cameras"], project["images"]
    used = {image["camera"] for image in images}
    if len(used) < 2 or 2 * len(used) < len(images):
        return project
    kinds = Counter(
        (cameras[image["camera"]]["model"], cameras[image["camera"]]["width"], cameras[image["camera"]]["height"]) for image in images
    )
    model, width, height = kind = kinds.most_common(1)[0][0]
    alike = [number for number in used if (cameras[number]["model"], cameras[number]["width"], cameras[number]["height"]) == kind]
    params = np.array([cameras[number]["params"] for number in alike])
    median = np.median(params, axis=0)
    account.assumed.append(
        f"the project has {len(alike)} cameras for {kinds[kind]} pictures: the median of their numbers is taken, "
        f"focal lengths differ from it by up to {100 * np.abs(params[:, 0] / median[0] - 1).max():.2g} %"
    )
    one = {"model": model, "width": width, "height": height, "params": median.tolist()}
    return {
        "cameras": cameras | {alike[0]: one},
        "images": [image | {"camera": alike[0]} if image["camera"] in alike else image for image in images],
    }


def read_cameras(file: pathlib.Path, asked: str) -> Lens:
    """The lens of cameras.txt or cameras.bin alone. @param asked  number of the camera, where the file has several"""
    with tempfile.TemporaryDirectory() as place:
        shutil.copyfile(file, pathlib.Path(place) / f"cameras{file.suffix}")
        for name in ("images", "points3D"):
            # A count of none, or no lines.
            (pathlib.Path(place) / f"{name}{file.suffix}").write_bytes(bytes(8) if file.suffix == ".bin" else b"")
        cameras = read_project(pathlib.Path(place), file)["cameras"]
    numbers = ", ".join(cameras) or "none"
    number = asked if asked in cameras else next(iter(cameras), None)
    if number != asked and len(cameras) != 1:
        raise BadInput(f"{file}: cameras in it: {numbers}; choose one by --camera NUMBER")
    return lens_of_camera(cameras[number], f"{file}, camera {number}")
