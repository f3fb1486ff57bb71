"""Files are whole or as they were, also on a disk that takes no more."""

import contextlib
import os
import pathlib
import subprocess
import sys

import pytest
from polhode_ground.common.whole_file import beside, write_whole
from polhode_ground.testing.synthetic import write_acquired

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


def test_a_file_is_whole_or_as_it_was(tmp_path):
    path = tmp_path / "folder/file.txt"
    write_whole(path, "old")
    with contextlib.suppress(ZeroDivisionError), beside(path, ours=True) as part:
        part.write_text("ne")
        1 / 0
    assert path.read_text() == "old" and list(path.parent.iterdir()) == [path]
    with beside(path, ours=True) as part:
        assert part.suffix == ".txt"
        part.write_bytes(b"new")
    assert path.read_text() == "new" and list(path.parent.iterdir()) == [path]


def test_a_link_stays_and_no_device_is_replaced(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_whole(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "file").read_text() == "text"
    os.mkfifo(tmp_path / "fifo")
    reader = os.open(tmp_path / "fifo", os.O_RDONLY | os.O_NONBLOCK)
    write_whole(tmp_path / "fifo", b"octets")
    assert os.read(reader, 100) == b"octets" and (tmp_path / "fifo").is_fifo()
    os.close(reader)


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 64 kB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", disk], capture_output=True).returncode != 0:
        pytest.skip("no disk can be mounted: tools/run_tests.sh as root has it")
    yield disk
    subprocess.run(["umount", "-l", disk], check=True)


def test_a_full_disk_is_one_line_and_leaves_no_part_of_a_page(small_disk, tmp_path):
    sequence, run = write_acquired(tmp_path, frames=40)
    (small_disk / "filler").write_bytes(b"x" * (60 << 10))
    for command, out in ((["tools/report.py", run, "--out"], "page.html"), (["hil/evaluate.py", run, sequence, "--json"], "judgement.json")):
        done = subprocess.run([sys.executable, REPOSITORY / command[0], *command[1:], small_disk / out], capture_output=True, text=True)
        assert done.returncode != 0 and len(done.stderr.strip().splitlines()) == 1, done.stderr
        assert "No space left on device" in done.stderr and out in done.stderr
        assert [file.name for file in small_disk.iterdir()] == ["filler"]
