"""Reads a COLMAP project by pycolmap, text or binary, and prints it as JSON. Runs in COLMAP's own environment.

Call: colmap_project_worker.py FOLDER. {"cameras": {id: {"model", "width", "height", "params"}}, "images": [{"name", "camera"}]},
pictures by name; cameras that have none are left out.
"""

import json
import sys

import pycolmap


def main() -> None:
    model = pycolmap.Reconstruction(sys.argv[1])
    images = sorted(({"name": image.name, "camera": str(image.camera_id)} for image in model.images.values()), key=lambda one: one["name"])
    used = {image["camera"] for image in images}
    cameras = {str(number): {"model": camera.model.name, "width": camera.width, "height": camera.height, "params": list(map(float, camera.params))}
               for number, camera in model.cameras.items() if str(number) in used}
    print(json.dumps({"cameras": cameras, "images": images}))


if __name__ == "__main__":
    main()
