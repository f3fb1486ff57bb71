"""clang-format decides how C++ looks."""

import pathlib
import shutil
import subprocess

import pytest
from source_tree import REPOSITORY, is_generated, name_of, source_files

FILES = [file for file in source_files(suffixes=(".cpp", ".hpp")) if not is_generated(file)]


@pytest.mark.skipif(not shutil.which("clang-format"), reason="clang-format is not installed (tools/setup.sh tests)")
def test_every_file_is_formatted():
    done = subprocess.run(["clang-format", "--dry-run", "--Werror", *FILES], capture_output=True, text=True, cwd=REPOSITORY, timeout=300)
    wrong = sorted({line.split(":")[0] for line in done.stderr.splitlines() if "error:" in line})
    assert done.returncode == 0, "clang-format -i " + " ".join(name_of(pathlib.Path(file)) for file in wrong)


@pytest.mark.skipif(not shutil.which("clang-format"), reason="clang-format is not installed (tools/setup.sh tests)")
def test_what_is_not_formatted_is_found(tmp_path):
    file = tmp_path / "wrong.cpp"
    shutil.copy(REPOSITORY / ".clang-format", tmp_path)
    file.write_text("int  f( ) {return 1 ;}\n")
    assert subprocess.run(["clang-format", "--dry-run", "--Werror", file], capture_output=True, timeout=60).returncode != 0
