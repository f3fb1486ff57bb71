"""A COLMAP project: pictures and the camera that COLMAP found for them. Its poses are left out."""

import pathlib
from collections import Counter
from collections.abc import Iterator

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.colmap_lens import lens_of_camera, with_one_camera
from polhode_ground.importing.colmap_library import read_project
from polhode_ground.importing.folder import frames_of, times_of
from polhode_ground.importing.pictures import in_folder, natural_order
from polhode_ground.importing.source import OTHER_CAMERA, Account, Frame, Options, Source, lens_if_any

# Of cameras and images below a project's folder, the first group that has any: where COLMAP, its undistorter and others put models.
PLACES = (("",), ("sparse/*", "sparse"), ("[0-9]*",), ("dense/sparse", "dense/*/sparse"), ("colmap/sparse/*", "distorted/sparse/*"))


def model_folder(path: pathlib.Path) -> pathlib.Path | None:
    """A folder with a model of the project; None where there is none."""
    return next(iter(model_folders(path)), None)


def model_folders(path: pathlib.Path) -> list[pathlib.Path]:
    """A project that falls apart has several, which share no point."""
    for places in PLACES:
        found = [
            folder for place in places for folder in (sorted(path.glob(place), key=natural_order) if place else [path]) if _is_model(folder)
        ]
        if found:
            return found
    return []


def _is_model(folder: pathlib.Path) -> bool:
    return any((folder / f"cameras.{suffix}").is_file() and (folder / f"images.{suffix}").is_file() for suffix in ("bin", "txt"))


def largest_model(path: pathlib.Path) -> tuple[pathlib.Path, str]:
    """(the model with most pictures, which others there are in words). @errors BadInput where two are the largest"""
    folders = model_folders(path)
    counts = {folder: _picture_count(folder) for folder in folders}
    folders.sort(key=lambda folder: -counts[folder])
    listed = ", ".join(f"{folder.relative_to(path)} ({counts[folder]})" for folder in folders)
    equal = [folder for folder in folders if counts[folder] == counts[folders[0]] and not _same_model(folder, folders[0])]
    if equal:
        raise BadInput(
            f"{path}: {len(folders)} models, by their pictures: {listed}; the largest are equal: name the folder of one as SOURCE"
        )
    said = (
        f"{len(folders)} models, by their pictures: {listed}; the largest is taken, the others' pictures are left out"
        if len(folders) > 1
        else ""
    )
    return folders[0], said


def _same_model(one: pathlib.Path, other: pathlib.Path) -> bool:
    return all(
        (one / name).read_bytes() == (other / name).read_bytes()
        for name in ("images.bin", "images.txt")
        if (one / name).is_file() and (other / name).is_file()
    )


def _picture_count(folder: pathlib.Path) -> int:
    """As COLMAP's formats have it: a number of 8 octets at the beginning, or two lines of text for each picture."""
    if (folder / "images.bin").is_file():
        with open(folder / "images.bin", "rb") as file:
            return int.from_bytes(file.read(8), "little")
    lines = (folder / "images.txt").read_text(errors="replace").splitlines()
    return (sum(not line.startswith("#") for line in lines) + 1) // 2


def open_colmap(path: pathlib.Path, options: Options) -> Source:
    folder, others_said = largest_model(path)
    account = Account()
    project = with_one_camera(read_project(folder), account)
    if not project["images"]:
        raise BadInput(f"{folder}: a COLMAP model without pictures")
    account.assumed += [others_said] if others_said else []
    number, count = Counter(image["camera"] for image in project["images"]).most_common(1)[0]
    others = len(project["images"]) - count
    if others:
        account.dropped[OTHER_CAMERA] += others
    _with_slashes(path, folder, project["images"])
    names = [image["name"] for image in project["images"] if image["camera"] == number]
    root = _picture_folder(path, folder, names)
    registered = {root / name for name in names}
    files = _all_pictures(root, registered, {root / image["name"] for image in project["images"]} - registered)
    times_ns, nominal, said = times_of(files, options.rate_hz, root)
    account.assumed += [*said, "COLMAP's poses are left out: Polhode finds its own"]
    if len(files) > count:
        account.assumed.append(
            f"{len(files) - count} of {len(files)} pictures are not registered in the model: they are left out, the times keep the gaps"
        )
    lens, lens_from = lens_if_any(
        lambda: (lens_of_camera(project["cameras"][number], str(folder)), f"the project's camera {number}"), account
    )
    return Source(
        f"COLMAP project, {count} pictures, camera {project['cameras'][number]['model']}",
        _registered(frames_of(files, times_ns), registered, account),
        account,
        times_ns,
        count,
        lens,
        lens_from,
        nominal,
    )


def _with_slashes(path: pathlib.Path, model: pathlib.Path, images: list[dict]) -> None:
    """Names that Windows wrote, where no picture has such a name here."""
    if any("\\" in image["name"] for image in images) and not any(
        (root / image["name"]).is_file() for root in _roots(path, model) for image in images
    ):
        for image in images:
            image["name"] = image["name"].replace("\\", "/")


def _roots(path: pathlib.Path, model: pathlib.Path) -> tuple[pathlib.Path, ...]:
    return path / "images", path, model.parent / "images", model.parent.parent / "images", model / "images"


def _all_pictures(root: pathlib.Path, registered: set[pathlib.Path], others: set[pathlib.Path]) -> list[pathlib.Path]:
    """In order, those too that COLMAP did not register: they tell the gaps. @param others  of other cameras"""
    beside = {file for folder in {file.parent for file in registered} for file in in_folder(folder)}
    return sorted(
        (beside | registered) - others, key=lambda file: [natural_order(pathlib.Path(part)) for part in file.relative_to(root).parts]
    )


def _registered(frames: Iterator[Frame], registered: set[pathlib.Path], account: Account) -> Iterator[Frame]:
    for frame in frames:
        if frame.file in registered:
            yield frame
        else:
            account.dropped["not registered in the COLMAP model"] += 1


def _picture_folder(path: pathlib.Path, model: pathlib.Path, names: list[str]) -> pathlib.Path:
    """Where most of them are; a picture that is missing costs itself."""
    roots = _roots(path, model)
    counts = [sum((root / name).is_file() for name in names) for root in roots]
    if not any(counts):
        raise BadInput(f"{path}: the project's pictures ({names[0]}, ...) are not there; expected in {path / 'images'}")
    return roots[counts.index(max(counts))]
