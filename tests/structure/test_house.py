"""The laws of the house that a program can check: where arrows point, what fsw must not know, how long things get."""

import re

import pytest
from source_tree import (ROOTS, code_of, cpp_functions, name_of, own_includes, python_functions, source_files,
                         system_includes, REPOSITORY)

FOUNDATION = ["base", "geometry", "solve"]
FLOW = ["image", "mask", "features", "tracks", "initialisation", "map", "shape", "motion", "bus", "pipeline"]
STAGES = FOUNDATION + FLOW

FILE_LINES_MAX = 400
FUNCTION_LINES_MAX = 60

# The machine: clocks, threads, files, text streams, the process and its environment; chance that has no seed.
MACHINE_HEADERS = re.compile(
    r"thread|mutex|shared_mutex|condition_variable|future|semaphore|latch|barrier|stop_token|chrono|ctime|time\.h|iostream|fstream|"
    r"sstream|ostream|istream|cstdio|stdio\.h|filesystem|random|unistd\.h|fcntl\.h|pthread\.h|sched\.h|signal\.h|csignal|"
    r"sys/.*|fmt/.*")
MACHINE_CALLS = re.compile(
    r"\b(?:getenv|setenv|printf|fprintf|puts|fopen|clock|srand|system|sleep|usleep|exit|quick_exit|_exit)\s*\(|"
    r"\btime\s*\(\s*(?:0|NULL|nullptr|&\w+)\s*\)|\bstd::rand\b|"
    r"\bstd::(?:cout|cerr|clog|thread|mutex|unordered_map|unordered_set|random_device)\b|\bcv::(?:theRNG|setNumThreads|RNG)\b")
SOLVER_HEADERS = re.compile(r"(?:opengv|ceres|flann|opencv2/flann).*")


def allowed_from(folder: str) -> list[str]:
    if folder in FOUNDATION:
        return FOUNDATION[: FOUNDATION.index(folder) + 1]
    return FOUNDATION + FLOW[: FLOW.index(folder) + 1]


def stage_of(file) -> str:
    return file.relative_to(REPOSITORY / "fsw").parts[0]


@pytest.mark.parametrize("stage", STAGES)
def test_no_arrow_runs_back(stage):
    allowed = allowed_from(stage)
    wrong = []
    for file in source_files(f"fsw/{stage}", suffixes=(".cpp", ".hpp")):
        for include in own_includes(file):
            folder = include.split("/")[0]
            if include != "config/limits.hpp" and folder not in allowed:
                wrong.append(f"{name_of(file)} includes {include}; {stage} may include {', '.join(allowed)}")
    assert not wrong, "\n".join(wrong)


def test_every_folder_of_fsw_is_a_stage():
    folders = {file.name for file in (REPOSITORY / "fsw").iterdir() if file.is_dir()}
    assert folders == set(STAGES)


@pytest.mark.parametrize("stage", STAGES)
def test_fsw_knows_no_machine(stage):
    wrong = []
    for file in source_files(f"fsw/{stage}", suffixes=(".cpp", ".hpp")):
        wrong += [f"{name_of(file)} includes <{header}>" for header in system_includes(file)
                  if MACHINE_HEADERS.fullmatch(header)]
        for number, line in enumerate(code_of(file).splitlines(), 1):
            if MACHINE_CALLS.search(line):
                wrong.append(f"{name_of(file)}:{number}: {line.strip()}")
    assert not wrong, "\n".join(wrong)


def test_only_solve_sees_the_solvers():
    wrong = [f"{name_of(file)} includes <{header}>" for file in source_files("fsw", suffixes=(".cpp", ".hpp"))
             if stage_of(file) != "solve" for header in system_includes(file) if SOLVER_HEADERS.fullmatch(header)]
    assert not wrong, "\n".join(wrong)


def test_fsw_does_not_know_the_platform():
    folders = {file.name for file in (REPOSITORY / "platform").iterdir() if file.is_dir()}
    wrong = [f"{name_of(file)} includes {include}" for file in source_files("fsw", suffixes=(".cpp", ".hpp"))
             for include in own_includes(file) if include.split("/")[0] in folders | {"platform"}]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("root", ROOTS)
def test_no_file_is_longer_than_400_lines(root):
    long = [f"{name_of(file)}: {lines} lines" for file in source_files(root)
            if (lines := len(file.read_text().splitlines())) > FILE_LINES_MAX]
    assert not long, "\n".join(long)


@pytest.mark.parametrize("root", ROOTS)
def test_no_function_is_longer_than_60_lines(root):
    long = []
    for file in source_files(root, suffixes=(".cpp", ".hpp", ".py")):
        functions = python_functions(file) if file.suffix == ".py" else cpp_functions(file)
        long += [f"{name_of(file)}:{line}: {length} lines" for line, length in functions if length > FUNCTION_LINES_MAX]
    assert not long, "\n".join(long)


def test_functions_are_found_at_all():
    """The measure would pass on anything if it found nothing."""
    found = cpp_functions(REPOSITORY / "fsw/base/crc.cpp")
    assert [length for _, length in found] == [11, 8]


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_says_what_it_is(stage):
    text = (REPOSITORY / "fsw" / stage / "README.md").read_text()
    assert len(text.splitlines()) <= 40


def test_no_file_names_a_place_of_one_machine():
    places = re.compile("(?:^|[\\s\"'=(])/(?:" + "work|root|home" + ")/\\w")
    wrong = [f"{name_of(file)}:{number}" for file in source_files() + source_files("docs", suffixes=(".md",))
             for number, line in enumerate(file.read_text().splitlines(), 1) if places.search(line)]
    assert not wrong, "\n".join(wrong)
