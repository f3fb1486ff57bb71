"""The installed library serves a program that knows nothing but find_package(polhode)."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("POLHODE_BUILD", REPOSITORY / "build/release"))
CONSUMER = pathlib.Path(__file__).parent / "consumer"


def run(*command) -> str:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    if not (BUILD / "CMakeCache.txt").exists():
        pytest.skip(f"{BUILD} is not built")
    folder = tmp_path_factory.mktemp("installed")
    run("cmake", "--install", BUILD, "--prefix", folder)
    return folder


# verifies: DEL-06
@pytest.mark.slow
def test_a_program_of_twenty_lines_builds_and_runs(prefix, tmp_path):
    shutil.copytree(CONSUMER, tmp_path / "consumer")
    run("cmake", "-S", tmp_path / "consumer", "-B", tmp_path / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
        "-DCMAKE_BUILD_TYPE=Release")
    run("cmake", "--build", tmp_path / "build")
    lines = run(tmp_path / "build/consumer").splitlines()
    assert len(lines) == 3
    assert all(re.fullmatch(r"[1-9]\d* octets for the bus, pose unknown", line) for line in lines), lines


def test_a_c_host_builds_by_pkg_config_wherever_the_installation_is_moved(prefix, tmp_path):
    moved = tmp_path / "moved"
    shutil.copytree(prefix, moved, symlinks=True, ignore=lambda folder, names: [name for name in names if name == "bin" or name.endswith(".a")])
    library = next(moved.rglob("libpolhode.so.1")).parent
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "polhode"], capture_output=True, text=True, check=True,
                           env={**os.environ, "PKG_CONFIG_PATH": str(library / "pkgconfig")}).stdout.split()
    assert all(str(moved) in flag for flag in flags if flag.startswith(("-I", "-L"))) and len(flags) == 3
    example = REPOSITORY / "platform/capi/example"
    run("gcc", "-std=c11", example / "main.c", example / "sequence.c", *flags, "-lpng", "-o", tmp_path / "host", f"-Wl,-rpath,{library}")
    done = subprocess.run([tmp_path / "host"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "usage" in done.stderr


@pytest.mark.parametrize(("libdir", "includedir", "expected"), [
    ("lib", "include", ["${pcfiledir}/../..", "${prefix}/lib", "${prefix}/include"]),
    ("lib/x86_64-linux-gnu", "include", ["${pcfiledir}/../../..", "${prefix}/lib/x86_64-linux-gnu", "${prefix}/include"]),
    ("/opt/a/lib", "/opt/b/include", ["/usr/local", "/opt/a/lib", "/opt/b/include"]),
])
def test_pkg_config_finds_folders_that_are_named_otherwise(tmp_path, libdir, includedir, expected):
    """The part of the build's description that writes the file, by itself: a whole configuration takes long."""
    lines = (REPOSITORY / "CMakeLists.txt").read_text()
    part = re.search(r"^if\(IS_ABSOLUTE.*?^configure_file\(config/polhode.pc.in[^\n]*", lines, re.DOTALL | re.MULTILINE)[0]
    (tmp_path / "config").mkdir()
    shutil.copy(REPOSITORY / "config/polhode.pc.in", tmp_path / "config")
    (tmp_path / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.25)\nproject(polhode VERSION 1 LANGUAGES NONE)\n{part}\n")
    run("cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_INSTALL_LIBDIR={libdir}", f"-DCMAKE_INSTALL_INCLUDEDIR={includedir}")
    lines = (tmp_path / "build/polhode.pc").read_text().splitlines()
    assert [line.split("=")[1] for line in lines[:3]] == expected


def test_only_the_public_header_and_what_it_includes_is_installed(prefix):
    include = prefix / "include/polhode"
    installed = {str(file.relative_to(include)) for file in include.rglob("*.hpp")}
    needed, queue = set(), ["pipeline/component.hpp"]
    while queue:
        header = queue.pop()
        if header not in needed:
            needed.add(header)
            queue += re.findall(r'#include "([^"]+)"', (REPOSITORY / "fsw" / header).read_text())
    assert installed == needed


@pytest.mark.parametrize("name", ["default", "standard", "full"])
def test_the_program_and_its_configurations_are_installed(prefix, name):
    assert run(prefix / "bin/polhode", "check", "--config", prefix / f"share/polhode/{name}.toml")


def test_the_service_is_installed_with_the_program_and_the_notes_that_it_names(prefix):
    unit = (prefix / "lib/systemd/system/polhode.service").read_text()
    named = re.findall(r"(?:Documentation=file:|ExecStart=)/usr/(\S+)", unit)
    assert len(named) == 2
    assert all((prefix / path).is_file() for path in named), named
    assert (prefix / "share/polhode/live.toml").is_file()


# verifies: DEL-06
def test_readme_shows_the_program_that_is_built():
    blocks = re.findall(r"```cpp\n(.*?)```", (REPOSITORY / "docs/library.md").read_text(), re.DOTALL)
    program = (CONSUMER / "main.cpp").read_text().split("\n", 1)[1]  # without the remark about docs/library.md
    assert program in blocks


def test_installing_the_python_client_leaves_its_folder_alone(tmp_path):
    """pip builds where the sources are, and setuptools would leave a build folder there."""
    source = REPOSITORY / "platform/transport/client/python"
    before = sorted(path for path in source.rglob("*") if "__pycache__" not in path.parts)
    done = subprocess.run([sys.executable, "-m", "pip", "install", "--disable-pip-version-check", "--quiet", "--no-deps", "--target", tmp_path, source],
                          capture_output=True, text=True, timeout=120)
    if "flit_core" in done.stderr and done.returncode != 0:
        pytest.skip(f"flit_core cannot be fetched: {done.stderr.splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "polhode_bus/decode.py").exists()
    assert sorted(path for path in source.rglob("*") if "__pycache__" not in path.parts) == before
