"""clang-tidy on what has changed; on everything by tools/tidy.sh --all, which takes ten to thirty minutes."""

import shutil
import subprocess

import pytest
from source_tree import REPOSITORY

FILES_MAX = 8  # a file takes about ten seconds
DATABASE = REPOSITORY / "build/release/compile_commands.json"

needs_clang_tidy = pytest.mark.skipif(not shutil.which("clang-tidy") or not DATABASE.exists(),
                                      reason="clang-tidy or a build is missing (tools/setup.sh tests, tools/build.sh release)")


def tidy(*arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([REPOSITORY / "tools/tidy.sh", *arguments], capture_output=True, text=True, cwd=REPOSITORY, timeout=900)


@needs_clang_tidy
def test_changed_files_are_tidy():
    changed = tidy("--list").stdout.split()
    done = tidy(*changed[:FILES_MAX])
    assert done.returncode == 0, done.stdout[-4000:]


@needs_clang_tidy
def test_what_is_not_tidy_is_found(tmp_path):
    bad = tmp_path / "bad.cpp"
    bad.write_text("int half(int n) { return n / 2; }\nint Sum(int n) { int a; return n; }\n")
    done = subprocess.run(["clang-tidy", "--quiet", f"--config-file={REPOSITORY / '.clang-tidy'}", bad, "--", "-std=c++20"],
                          capture_output=True, text=True, timeout=120)
    assert done.returncode != 0
    assert "readability-identifier-naming" in done.stdout and "cppcoreguidelines-init-variables" in done.stdout


def test_what_it_cannot_use_is_refused_in_words():
    done = tidy("--fast")
    assert done.returncode == 2 and "--fast" in done.stderr and "--all" in done.stderr
