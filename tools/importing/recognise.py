"""Which kind of source a path is, by what is in it."""

import pathlib

from importing import bag, colmap_project, folder, listed, video
from importing.pictures import in_folder
from importing.source import Options, Source

from judge.errors import BadInput

EXPECTED = "a video, a folder of pictures, a TUM or EuRoC sequence, a COLMAP project, a ROS bag or an MCAP file"


def _folder_kinds(path: pathlib.Path, options: Options):
    """In the order in which they are told apart: the most particular first."""
    return (
        (bag.is_bag(path), bag.open_bag),
        (colmap_project.model_folder(path) is not None, colmap_project.open_colmap),
        (listed.camera_folder(path, options.camera) is not None, listed.open_euroc),
        (listed.tum_list(path) is not None, listed.open_tum),
        (bool(in_folder(path)), folder.open_folder),
    )


def open_source(path: pathlib.Path, options: Options) -> Source:
    if path.is_dir():
        for fits, opener in _folder_kinds(path, options):
            if fits:
                return opener(path, options)
        raise BadInput(f"{path}: found {_contents(path)}; expected {EXPECTED}")
    if not path.exists():
        raise BadInput(f"{path}: not there; expected {EXPECTED}")
    if bag.is_bag(path):
        return bag.open_bag(path, options)
    try:
        return video.open_video(path, options)
    except BadInput as problem:
        raise BadInput(f"{problem}; expected {EXPECTED}") from None


def _contents(path: pathlib.Path) -> str:
    names = sorted(entry.name + ("/" if entry.is_dir() else "") for entry in path.iterdir())
    shown = ", ".join(names[:5])
    return f"a folder with {shown}{f' and {len(names) - 5} more' if len(names) > 5 else ''}" if names else "an empty folder"
