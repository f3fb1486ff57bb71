"""tools/check_packages.py on made-up packages: what is whole passes, and each fault that it shall find is found."""

import pathlib
import re
import subprocess
import sys

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
HERE = subprocess.run(["dpkg", "--print-architecture"], capture_output=True, text=True, check=False).stdout.strip()
OTHER = {"amd64": "arm64", "arm64": "amd64"}.get(HERE)
pytestmark = pytest.mark.skipif(OTHER is None, reason=f"for amd64 and arm64 only; this machine is {HERE}")


def run(*command, **more) -> str:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **more)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def program(tmp_path_factory) -> pathlib.Path:
    """Needs a library of a package, libpng, and one that is packaged with it, libown."""
    folder = tmp_path_factory.mktemp("program")
    run("gcc", "-g", "-shared", "-x", "c", "/dev/null", "-Wl,-soname,libown.so.1", "-Wl,--build-id", "-o", folder / "libown.so.1")
    run("gcc", "-g", "-x", "c", "-", "-x", "none", "-Wl,--no-as-needed,--build-id", folder / "libown.so.1", "-lpng16", "-o", folder / "program",
        input="int main(void) { return 0; }")
    return folder / "program"


def build(folder: pathlib.Path, name: str, files: dict[str, pathlib.Path], suffix: str = "deb", **fields: str) -> None:
    tree = folder.parent / f"{folder.name}-{name}"
    for path, source in files.items():
        (tree / path).parent.mkdir(parents=True, exist_ok=True)
        (tree / path).write_bytes(source.read_bytes())
    (tree / "DEBIAN").mkdir(parents=True)
    fields = {"Package": name, "Version": "1", "Architecture": HERE, "Section": "science", "Maintainer": "A <a@b>", "Description": "one"} | fields
    (tree / "DEBIAN/control").write_text("".join(f"{field}: {value}\n" for field, value in fields.items()))
    folder.mkdir(exist_ok=True)
    run("dpkg-deb", "--root-owner-group", "--build", tree, folder / f"{name}_1_x.{suffix}")


def pack(folder: pathlib.Path, binary: pathlib.Path, name: str, path: str, strip: bool = True, more: dict | None = None, **fields: str) -> None:
    """A program or library, with its debug symbols in a package apart."""
    work = folder.parent
    work.mkdir(exist_ok=True)
    run("objcopy", "--only-keep-debug", binary, work / "debug")
    run("strip" if strip else "cp", binary, *(["-o"] if strip else []), work / "packed")
    first, rest = re.search(r"Build ID: (..)(\w+)", run("readelf", "-n", binary)).groups()
    build(folder, f"{name}-dbgsym", {f"usr/lib/debug/.build-id/{first}/{rest}.debug": work / "debug"}, suffix="ddeb")
    build(folder, name, {path: work / "packed"} | (more or {}), **fields)


def pack_both(folder: pathlib.Path, program: pathlib.Path, **more) -> pathlib.Path:
    pack(folder, program.parent / "libown.so.1", "libown1", "usr/lib/libown.so.1")
    pack(folder, program, "thing", "usr/bin/thing", **{"Depends": "libc6 (>= 2.0), libpng16-16 | libpng16-17, libown1 (= 1)"} | more)
    return folder


def check(*arguments) -> tuple[int, str, str]:
    done = subprocess.run([sys.executable, REPOSITORY / "tools/check_packages.py", *map(str, arguments)], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


# verifies: DEL-07
def test_what_is_whole_passes(tmp_path, program):
    folder = pack_both(tmp_path / "whole", program)
    build(folder, "words", {}, Architecture="all")
    assert check(folder, "--like", folder) == (0, f"libown1 1 {HERE}: 1 files, 0 libraries needed, 0 dependencies\n"
                                                  f"thing 1 {HERE}: 1 files, 3 libraries needed, 3 dependencies\n", "")


# verifies: DEL-07
@pytest.mark.parametrize(("depends", "says"), [
    ("libc6, libown1", "thing: needs libpng16.so.16, which is in libpng16-16, no dependency\n"),
    ("libc6, libpng16-16", "thing: needs libown.so.1, which is in libown1, no dependency\n"),
    ("libpng16-16, libown1", "thing: needs libc.so.6, which is in libc6, no dependency\n"),
])
def test_a_library_that_no_dependency_brings_is_named(tmp_path, program, depends, says):
    status, _, stderr = check(pack_both(tmp_path / "short", program, Depends=depends))
    assert status == 1 and stderr == f"check_packages: {says}"


def test_a_library_of_no_package_is_named(tmp_path, program):
    pack(tmp_path / "alone", program, "thing", "usr/bin/thing", Depends="libc6, libpng16-16")
    assert check(tmp_path / "alone")[::2] == (1, "check_packages: thing: needs libown.so.1, which no package has\n")


def test_debug_symbols_belong_into_a_package_apart(tmp_path, program):
    folder = pack_both(tmp_path / "fat", program, strip=False)
    (folder / "libown1-dbgsym_1_x.ddeb").unlink()
    status, _, stderr = check(folder)
    assert status == 1
    assert [line.partition(": ")[2] for line in stderr.splitlines()] == [
        "libown1: usr/lib/libown.so.1: its debug symbols are in no package libown1-dbgsym",
        "thing: usr/bin/thing: has debug symbols", "thing: usr/bin/thing: not stripped"]


def test_code_of_another_architecture_is_named(tmp_path, program):
    status, _, stderr = check(pack_both(tmp_path / "foreign", program, Architecture=OTHER))
    assert status == 1 and f"thing: usr/bin/thing: not of {OTHER} alone: " in stderr


# verifies: DEL-07
def test_differences_from_other_packages_are_named(tmp_path, program):
    ours, theirs = pack_both(tmp_path / "a/ours", program, Section="utils"), pack_both(
        tmp_path / "b/theirs", program, more={"usr/share/thing/notes": pathlib.Path(__file__)}, Depends="libc6, libpng16-16, libown1, libz3-4")
    build(theirs, "second", {})
    status, _, stderr = check(ours, "--like", theirs)
    assert status == 1
    assert [line.partition(": ")[2].replace(str(tmp_path), "") for line in stderr.splitlines()] == [
        f"second: not in {ours}".replace(str(tmp_path), ""), "thing: usr/share/thing/notes: only in /b/theirs/thing_1_x.deb",
        "thing: other Section than /b/theirs/thing_1_x.deb", "thing: libz3-4: a dependency only of /b/theirs/thing_1_x.deb"]


def test_what_is_no_package_is_refused(tmp_path):
    (tmp_path / "odd.deb").write_text("text")
    status, _, stderr = check(tmp_path)
    assert status == 2 and stderr == f"check_packages: {tmp_path}/odd.deb: not a Debian package\n"
    status, _, stderr = check(tmp_path, "--database", tmp_path)
    assert status == 2 and stderr.startswith(f"check_packages: --database: {tmp_path}: no database of dpkg") and stderr.count("\n") == 1
