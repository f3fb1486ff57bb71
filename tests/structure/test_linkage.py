"""What the program drags in: image codecs of the vision library cost 47 MB of memory and are not needed."""

import os
import pathlib
import subprocess

import pytest
from source_tree import REPOSITORY

PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))


# verifies: DEL-04
def test_no_codecs_windows_or_video_files_are_linked():
    if not PROGRAM.exists():
        pytest.skip(f"{PROGRAM} is not built")
    libraries = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
    for name in ("opencv_imgcodecs", "opencv_highgui", "opencv_videoio"):
        assert name not in libraries
