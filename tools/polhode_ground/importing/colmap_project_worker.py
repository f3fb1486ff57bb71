"""What only COLMAP's own library knows, by pycolmap. Runs in COLMAP's own environment.

Calls: colmap_project_worker.py read FOLDER, which prints a project, text or binary, as JSON: {"cameras": {id: {"model", "width",
"height", "params"}}, "images": [{"name", "camera"}]}, pictures by name.
colmap_project_worker.py project MODEL PARAMS DIRECTIONS.npy PLACES.npy: where a camera sees directions.
"""

import json
import os
import pathlib
import struct
import sys

import numpy as np
import pycolmap


def names_in_text(file: pathlib.Path) -> dict[int, str]:
    """Of images.txt: every second line is of points. The library takes a name up to its first blank."""
    lines = [line.strip() for line in file.read_text(errors="surrogateescape").splitlines()]
    names, of_points = {}, False
    for line in lines:
        if not of_points and (not line or line.startswith("#")):
            continue
        if not of_points:
            fields = line.split(maxsplit=9)
            names[int(fields[0])] = fields[9]
        of_points = not of_points
    return names


def names_in_binary(file: pathlib.Path) -> dict[int, str]:
    """Of images.bin, as COLMAP's documentation has it. The library does not see that a file ends early."""
    octets = file.read_bytes()
    names, at = {}, 8
    for _ in range(struct.unpack_from("<Q", octets)[0]):
        end = octets.index(b"\0", at + 64)
        names[struct.unpack_from("<I", octets, at)[0]] = os.fsdecode(octets[at + 64 : end])
        at = end + 9 + 24 * struct.unpack_from("<Q", octets, end + 1)[0]
    if at > len(octets):
        raise EOFError
    return names


def names_of(folder: pathlib.Path) -> dict[int, str]:
    binary = folder / "images.bin"
    try:
        return names_in_binary(binary) if binary.exists() else names_in_text(folder / "images.txt")
    except (EOFError, struct.error, ValueError, IndexError):
        sys.exit(f"{binary.name if binary.exists() else 'images.txt'} is cut or damaged")


def check_cameras(file: pathlib.Path, model) -> None:
    """The library fills up with zeros what a file lacks."""
    needed = 8 + sum(24 + 8 * len(camera.params) for camera in model.cameras.values())
    if file.exists() and file.stat().st_size < needed:
        sys.exit(f"cameras.bin is cut: it has {file.stat().st_size} octets, its cameras need {needed}")


def read(folder: str) -> None:
    names = names_of(pathlib.Path(folder))
    model = pycolmap.Reconstruction(folder)
    check_cameras(pathlib.Path(folder) / "cameras.bin", model)
    images = sorted(
        ({"name": names[number], "camera": str(image.camera_id)} for number, image in model.images.items()), key=lambda one: one["name"]
    )
    cameras = {
        str(number): {"model": camera.model.name, "width": camera.width, "height": camera.height, "params": list(map(float, camera.params))}
        for number, camera in sorted(model.cameras.items())
    }
    print(json.dumps({"cameras": cameras, "images": images}))


def project(model: str, params: str, directions: str, places: str) -> None:
    camera = pycolmap.Camera(model=model, width=1, height=1, params=json.loads(params))
    np.save(places, camera.img_from_cam(np.load(directions)))
    print(model)


if __name__ == "__main__":
    {"read": read, "project": project}[sys.argv[1]](*sys.argv[2:])
