"""What names an architecture is compiled for arm64, too. All of the program: tools/check_arm64.sh."""

import re
import shutil
import subprocess

import pytest
from source_tree import REPOSITORY, name_of, source_files

COMPILER = "aarch64-linux-gnu-g++"
ARCHITECTURE = re.compile(r"\b__(?:x86_64|aarch64|SSE\w*|AVX\w*|ARM\w*)__\b")
FILES = [file for root in ("fsw", "platform") for file in source_files(root, suffixes=(".cpp", ".hpp"))
         if ARCHITECTURE.search(file.read_text())]


# verifies: RES-06
def test_some_files_name_an_architecture():
    assert {name_of(file) for file in FILES} >= {"fsw/features/lanes.hpp", "platform/os/linux/memory/trap.cpp"}


# verifies: RES-06
@pytest.mark.further
@pytest.mark.skipif(not shutil.which(COMPILER), reason=f"{COMPILER} is not installed (tools/setup.sh arm64)")
@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_it_compiles_for_arm64(file):
    folders = [f"-I{REPOSITORY / folder}" for folder in ("", "fsw", "platform")]
    compiled = subprocess.run(
        [COMPILER, "-x", "c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion", "-Werror", *folders, "-include", file,
         "/dev/null"], capture_output=True, text=True, check=False)
    assert compiled.returncode == 0, compiled.stderr
