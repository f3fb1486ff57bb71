"""Which kind of source a path is, by what is in it."""

import pathlib

from polhode_ground.common.errors import BadInput
from polhode_ground.importing import animation, bag, colmap_project, folder, listed, stack, video
from polhode_ground.importing.formats import kind_of_file
from polhode_ground.importing.joined import JoinedVideos
from polhode_ground.importing.other_files import told_by_content, told_by_entries
from polhode_ground.importing.pictures import in_folder
from polhode_ground.importing.source import Options, Source

UNFINISHED = (".active",)  # ROS 1 names a bag so while it is recorded
RAW_DUMPS = " (raw dumps tell neither size nor depth: write them as PNG, TIFF or NumPy's .npy)"
EXPECTED = "a video, a folder of pictures, a TIFF of several pages, a TUM or EuRoC sequence, a COLMAP project, a ROS bag or an MCAP file"


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
        hint = told_by_entries(path)
        raise BadInput(f"{path}: found {_contents(path)}{f': {hint}' if hint else ''}; expected {EXPECTED}")
    if not path.exists():
        raise BadInput(f"{path}: not there; expected {EXPECTED}")
    if not path.stat().st_size:
        raise BadInput(f"{path}: an empty file; expected {EXPECTED}")
    if bag.is_bag(path):
        return bag.open_bag(path, options)
    if path.suffix in UNFINISHED:
        raise BadInput(
            f"{path}: a recording that its recorder did not close; give it the name without {path.suffix}, after `rosbag reindex` of a bag of ROS 1"
        )
    other = told_by_content(path)
    if other:
        raise BadInput(f"{path}: found {other}; expected {EXPECTED}")
    if animation.is_animation(path):
        return animation.open_animation(path, options)
    if stack.is_stack(path):
        return stack.open_stack(path, options)
    if kind_of_file(path) == "fits":
        raise BadInput(f"{path}: found a single picture; expected {EXPECTED}")
    try:
        return video.open_video(path, options)
    except JoinedVideos:
        raise
    except BadInput as problem:
        raise BadInput(f"{problem}; expected {EXPECTED}") from None


def _contents(path: pathlib.Path) -> str:
    names = sorted(entry.name + ("/" if entry.is_dir() else "") for entry in path.iterdir())
    shown = ", ".join(names[:5])
    raw = RAW_DUMPS if any(name.lower().endswith((".raw", ".bin", ".yuv", ".img", ".raw10", ".raw12", ".raw16")) for name in names) else ""
    return f"a folder with {shown}{f' and {len(names) - 5} more' if len(names) > 5 else ''}{raw}" if names else "an empty folder"
