"""No function that rounds by the processor is reached from a step: neither by the program nor by the libraries that it calls."""

import os
import pathlib
import re
import subprocess

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = REPOSITORY / "build/release/bin/polhode"
# Those whose code a step calls. What these load in turn, as neural networks and sparse solvers, is not called.
CALLED = ("opencv_core", "opencv_imgproc", "opencv_video", "opencv_calib3d", "opencv_flann", "opengv")
# Exact, correctly rounded, or (csqrt, hypotf) of one kind in the C library and made of square roots alone.
OF_ONE_KIND = {"ceil", "csqrt", "fmax", "fmaxf", "fminf", "fmod", "fmodf", "frexp", "hypotf", "ldexp", "llround", "lround", "lroundf", "nextafter",
               "round", "roundf", "sqrt", "sqrtf"}

pytestmark = pytest.mark.skipif(not PROGRAM.exists() or "POLHODE_RUNNER" in os.environ, reason="tools/build.sh makes the program")


def symbols(file, *options: str) -> set[str]:
    lines = subprocess.run(["nm", "-D", *options, file], capture_output=True, text=True, check=True).stdout.splitlines()
    return {line.split()[-1].split("@")[0] for line in lines}


@pytest.fixture(scope="module")
def loaded() -> dict[str, str]:
    """Path by name of every library that the program loads."""
    lines = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
    return {re.sub(r"^lib|\.so.*$", "", pathlib.Path(path).name): path for path in re.findall(r"=> (/\S+)", lines)}


@pytest.mark.parametrize("caller", ["polhode", *CALLED])
def test_what_rounds_by_the_processor_comes_from_the_program(loaded, caller):
    mathematics = symbols(loaded["m"], "--defined-only")
    wanted = symbols(PROGRAM if caller == "polhode" else loaded[caller], "--undefined-only") & mathematics
    assert wanted, "else the test says nothing"
    missing = wanted - symbols(PROGRAM, "--defined-only") - OF_ONE_KIND
    assert not missing, f"{caller} takes {', '.join(sorted(missing))} from the C library: fsw/base/elementary_functions.cpp should have them"


def test_ceres_is_in_the_program_where_its_caches_are_set(loaded):
    assert "ceres" not in loaded
