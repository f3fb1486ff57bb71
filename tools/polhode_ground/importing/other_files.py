"""Files that are no sequence, but often hold one: told by their first octets, with what to do."""

import pathlib

from polhode_ground.importing.formats import kind_of_file
from polhode_ground.importing.pictures import open_picture
from polhode_ground.importing.source import PICTURES, VIDEOS

UNPACK = "unpack it first"
BEGINNINGS = (
    (b"#ROSBAG V", "a bag of ROS 1", "give it a name that ends in .bag"),
    (b"\x89MCAP0\r\n", "an MCAP file", "give it a name that ends in .mcap"),
    (b"SQLite format 3\0", "a file of SQLite, as bags of ROS 2 are", "if it is one, give it a name that ends in .db3"),
    (b"PK\x03\x04", "a ZIP archive", UNPACK),
    (b"\x1f\x8b", "a file packed by gzip", UNPACK),
    (b"BZh", "a file packed by bzip2", UNPACK),
    (b"\xfd7zXZ\0", "a file packed by xz", UNPACK),
    (b"\x28\xb5\x2f\xfd", "a file packed by zstd", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"Rar!", "a RAR archive", UNPACK),
    (b"\x93NUMPY", "a NumPy array", "write its pictures into a folder"),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file", "write its pictures into a folder"),
    (b"MATLAB 5.0 MAT", "a file of Matlab", "write its pictures into a folder"),
)
TAR_AT, TAR = 257, b"ustar"


def told_by_content(path: pathlib.Path) -> str:
    """What it is and what to do; empty of others."""
    with open(path, "rb") as file:
        begin = file.read(TAR_AT + len(TAR))
    if begin[TAR_AT:] == TAR:
        return f"a tar archive: {UNPACK}"
    return next((f"{what}: {advice}" for octets, what, advice in BEGINNINGS if begin.startswith(octets)), "") or _several_jpegs(path)


def _several_jpegs(path: pathlib.Path) -> str:
    """MPO, as stereo cameras and Pillow write it. Its index is often wrong: what lies where is not taken from it."""
    if kind_of_file(path) != "jpeg":
        return ""
    with open_picture(path) as picture:
        count = getattr(picture, "n_frames", 1)
    return f"{count} JPEGs in one file (MPO): write those of one camera into a folder, and give --rate-hz" if count > 1 else ""


def told_by_entries(folder: pathlib.Path) -> str:
    """What to name in place of a folder that holds several sources."""
    videos = sorted(path.name for path in folder.iterdir() if path.suffix.lower() in VIDEOS)
    if videos:
        return f"it holds videos: name one of them, as {videos[0]}"
    below = sorted(
        path.name for path in folder.iterdir() if path.is_dir() and any(file.suffix.lower() in PICTURES for file in path.iterdir())
    )
    return f"pictures are in folders below: name one of them, as {below[0]}" if below else ""
