"""The laws of the house that a program can check: where arrows point, what fsw must not know, how long things get."""

import re

import pytest
from cpp_parts import MEMBERS_MAX, structs_of
from source_tree import REPOSITORY, ROOTS, code_of, cpp_functions, name_of, own_includes, python_functions, source_files, system_includes

FOUNDATION = ["base", "geometry", "solve"]
FLOW = ["image", "mask", "features", "tracks", "initialisation", "map", "shape", "motion", "bus", "pipeline"]
STAGES = FOUNDATION + FLOW

HEADERS_MAX = 40  # of the project's own that a header of fsw draws in
# These are made of the states of several rooms, each of which draws in its room.
COMPOSED = {
    "pipeline/state.hpp": "the states of all rooms",
    "pipeline/storage.hpp": "the component's memory: that of its state",
    "pipeline/job.hpp": "the tables of all long work",
}

# Passed to be changed by functions of other rooms than their own, though wide.
WIDE_BY_NATURE = {
    "MotionState": "the published row: pipeline fills it for the caller",
    "Counters": "changed by pipeline alone, which counts for all rooms",
}

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


# verifies: CMP-07
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


# verifies: CMP-06
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


def project_headers(header: str, seen: set[str]) -> set[str]:
    """All headers of the project that one draws in, itself not among them."""
    file = REPOSITORY / ("" if header.startswith("config/") else "fsw") / header
    for include in own_includes(file) if file.exists() else []:
        if include not in seen:
            seen.add(include)
            project_headers(include, seen)
    return seen


def test_no_header_draws_in_too_many():
    wrong = []
    for file in source_files("fsw", suffixes=(".hpp",)):
        name = str(file.relative_to(REPOSITORY / "fsw"))
        drawn_in = len(project_headers(name, {name})) - 1
        if drawn_in > HEADERS_MAX and name not in COMPOSED:
            wrong.append(f"{name} draws in {drawn_in} headers of the project, more than {HEADERS_MAX}")
    assert not wrong, "\n".join(wrong)


def test_the_public_headers_expose_no_internals():
    """What flies includes component.hpp; nothing of solvers, maps, jobs or OpenCV comes with it."""
    for public in ("pipeline/component.hpp", "pipeline/ground_view.hpp", "pipeline/checkpoint.hpp"):
        drawn_in = project_headers(public, {public}) - {public}
        internal = {name for name in drawn_in if name.split("/")[0] in ("solve", "map", "tracks", "features", "initialisation")
                    and not name.endswith("/options.hpp")}
        internal |= {name for name in drawn_in if name in ("pipeline/state.hpp", "pipeline/job.hpp", "bus/bus_state.hpp")}
        assert not internal, f"{public} exposes {', '.join(sorted(internal))}"


def test_the_state_is_for_the_pipeline_and_tests():
    wrong = [name_of(file) for file in source_files("fsw", "platform", "hil", suffixes=(".cpp", ".hpp"))
             if "pipeline/state.hpp" in own_includes(file) and "pipeline" not in file.parts]
    assert not wrong, f"{', '.join(wrong)} include pipeline/state.hpp: pipeline/ground_view.hpp is for them"


def test_no_room_changes_a_wide_struct_of_another():
    wide = {}
    for file in source_files("fsw", suffixes=(".hpp",)):
        for name, _, members in structs_of(file):
            if members > MEMBERS_MAX:
                wide[name] = (stage_of(file), members)
    wrong = []
    for file in source_files("fsw", suffixes=(".cpp", ".hpp")):
        for name in set(re.findall(r"(?<!const )\b(\w+)\* \w+[,)]", code_of(file))) & set(wide):
            if stage_of(file) != wide[name][0] and name not in WIDE_BY_NATURE:
                wrong.append(f"{name_of(file)} may change {name} of {wide[name][0]}, with {wide[name][1]} members")
    assert not wrong, "\n".join(wrong)


def test_step_names_what_flows_on_one_screen():
    file = REPOSITORY / "fsw/pipeline/step.cpp"
    begin = file.read_text().split("Component::step(")[0].count("\n")
    length = {first: lines for first, lines in cpp_functions(file)}
    step = min(lines for first, lines in length.items() if abs(first - 1 - begin) <= 1)
    assert step <= FUNCTION_LINES_MAX


def test_an_event_is_reported_by_its_own_function_alone():
    """log_event() takes numbers without names; the functions of event_reports.hpp call it."""
    allowed = {"fsw/bus/events.hpp", "fsw/bus/events.cpp", "fsw/bus/event_reports.cpp"}
    wrong = [name_of(file) for file in source_files("fsw", "platform", suffixes=(".cpp", ".hpp"))
             if re.search(r"\blog_event\(", code_of(file)) and name_of(file) not in allowed]
    assert not wrong, wrong
