"""The focal length of a sequence, estimated on the ground from its pictures alone, by COLMAP's adjustment (pycolmap)."""

import json
import pathlib
import subprocess
import sys
import tempfile

from polhode_ground.common.errors import BadInput
from polhode_ground.common.sequence import Camera, Sequence, read_sequence
from polhode_ground.common.whole_file import write_whole
from polhode_ground.importing.lens import Lens
from polhode_ground.importing.pixel_shape import aspect_of, stretch, stretch_of
from polhode_ground.importing.sensor_text import with_intrinsics
from polhode_ground.importing.writing import numbers_text
from polhode_ground.judge.colmap import ensure_venv, prepare_images

WORKER = pathlib.Path(__file__).with_name("focal_worker.py")
# All pairs of 100 pictures are matched in half a minute on two cores; more pictures hardly tell more.
PICTURES_MAX = 100
PICTURES_MIN = 8
# Below this share of the pictures in one model, the model is of a part of the motion or of something else.
PLACED_SHARE_MIN = 0.5
# A focal length that is less well known than this is worse than EXIF's.
SIGMA_MAX_RELATIVE = 0.03
# Where the search begins, in longer edges of the picture: a wide lens and a long one.
START_FACTORS = (1.2, 2.4)


def estimate_and_write(folder: pathlib.Path) -> int:
    """Replaces the intrinsics in the sequence's sensor.yaml. @return 0, or 1 where the pictures do not tell."""
    sensor = folder / "mav0/cam0/sensor.yaml"
    sequence = read_sequence(folder, any_lens=True)
    exchanged(sensor, "", "[1, 1, 1, 1]", 1.0)  # what can't be written must not be estimated for minutes
    why, python = "no try was made", ensure_venv()
    for names, words in selections(sequence):
        for factor in START_FACTORS:
            found = run_worker(python, sequence, names, factor)
            why = refusal(found, len(names))
            if not why:
                write(sensor, sequence.camera, found, len(names))
                return 0
            print(f"{words}, from {factor:g} picture widths: {why}", file=sys.stderr)
    print(
        f"import_sequence: {folder}: the focal length can't be known from these pictures: {why}; calibrate the camera "
        "(tools/calibrate_camera.py) or give --intrinsics FILE",
        file=sys.stderr,
    )
    return 1


def selections(sequence: Sequence) -> list[tuple[list[int], str]]:
    """Which frames to try: spread over the sequence; then its beginning, where neighbours in the first are too far apart."""
    count = len(sequence.filenames)
    if count < PICTURES_MIN:
        raise BadInput(f"{sequence.folder}: {count} frames, at least {PICTURES_MIN} are needed to estimate the focal length")
    step = -(-count // PICTURES_MAX)
    tries = [(list(range(0, count, step)), f"every {step}. frame" if step > 1 else "all frames")]
    return tries + ([(list(range(PICTURES_MAX)), f"the first {PICTURES_MAX} frames")] if step > 1 else [])


def run_worker(python: pathlib.Path, sequence: Sequence, indices: list[int], factor: float) -> dict:
    """The worker's answer: {"placed", "points", "focal_px", "sigma_px", "residual_px"} or {"placed": 0}; the focal length is fu."""
    camera, by = sequence.camera, stretch_of(aspect_of(sequence.folder / "mav0/cam0/sensor.yaml"))
    with tempfile.TemporaryDirectory() as place:
        work = pathlib.Path(place)
        part = Sequence(sequence.folder, camera, sequence.timestamp_ns[indices], [sequence.filenames[i] for i in indices])
        names = prepare_images(part, work / "images")
        stretch(work / "images", names, by)
        centre_px = [factor * (float(place) + 0.5) - 0.5 for factor, place in zip(by, camera.intrinsics_px[2:])]
        job = {
            "images": str(work / "images"),
            "names": names,
            "work": str(work / "colmap"),
            "result": str(work / "result.json"),
            "focal_px": factor * max(camera.width_px * by[0], camera.height_px * by[1]),
            "centre_px": centre_px,
            "k1_k2": [float(value) for value in camera.distortion[:2]],
        }
        (work / "job.json").write_text(json.dumps(job))
        print(f"estimating the focal length from {len(names)} frames, a minute or so", file=sys.stderr)
        done = subprocess.run([python, WORKER, work / "job.json"], capture_output=True, text=True, errors="backslashreplace")
        if done.returncode != 0:
            raise BadInput(f"{sequence.folder}: COLMAP ended with {done.returncode}: {' '.join(done.stderr.strip().splitlines()[-1:])}")
        found = json.loads((work / "result.json").read_text())
    return found | {key: found[key] / by[0] for key in ("focal_px", "sigma_px") if found.get(key)}


def refusal(found: dict, pictures: int) -> str:
    """Why the answer is of no use; empty where it is."""
    if found["placed"] < max(PICTURES_MIN, PLACED_SHARE_MIN * pictures):
        return f"only {found['placed']} of {pictures} frames could be placed about the target (it must turn, and show texture)"
    if found["sigma_px"] is None or found["sigma_px"] > SIGMA_MAX_RELATIVE * found["focal_px"]:
        sigma = "unbounded" if found["sigma_px"] is None else f"{100 * found['sigma_px'] / found['focal_px']:.1f} %"
        return f"its sigma is {sigma}, allowed is {100 * SIGMA_MAX_RELATIVE:g} % (the target turns too little, or looks flat from so far)"
    return ""


def exchanged(sensor: pathlib.Path, said: str, intrinsics: str, sigma_px: float) -> str:
    """The new text. @errors BadInput where it can't be made without a change of other fields"""
    text = sensor.read_bytes().decode("utf-8-sig", errors="surrogateescape")  # with its own line ends
    try:
        return with_intrinsics(text, said, intrinsics, sigma_px)
    except BadInput as problem:
        raise BadInput(f"{sensor}: {problem}") from None


def write(sensor: pathlib.Path, camera: Camera, found: dict, pictures: int) -> None:
    focal, sigma = found["focal_px"], found["sigma_px"]
    lens = Lens(camera.width_px, camera.height_px, (focal, focal * aspect_of(sensor), *camera.intrinsics_px[2:]))
    said = f"focal length estimated from {found['placed']} of {pictures} frames: {focal:.2f} px, 1 sigma {sigma:.2f} px ({100 * sigma / focal:.2f} %)"
    new = exchanged(sensor, said, numbers_text(lens), sigma)
    write_whole(sensor, new, ours=True)  # the user has asked for it
    record = sensor.parents[2] / "import.json"
    if record.exists():
        write_whole(record, json.dumps(json.loads(record.read_text()) | {"intrinsics_from": said}, indent=2) + "\n", ours=True)
    print(f"{said}; {found['points']} points, residual {found['residual_px']:.2f} px; written to {sensor}")
