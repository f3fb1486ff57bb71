"""polhode.h as hosts in C and Python meet it: its symbols, its answers to mistakes, the sample's stream."""

import ctypes as c
import os
import pathlib
import re
import subprocess
import sys

import numpy
import pytest
from polhode_ctypes import Camera, Component, Input, Octets, Output, load, packets_of
from polhode_ground.checking import golden

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

BUILD = pathlib.Path(os.environ.get("POLHODE_BUILD", REPOSITORY / "build/release"))
LIBRARY = BUILD / "platform/libpolhode.so"
HEADER = REPOSITORY / "platform/capi/polhode.h"
SAMPLE = REPOSITORY / "hil/data/sample"
pytestmark = pytest.mark.skipif(not LIBRARY.exists() or "POLHODE_RUNNER" in os.environ, reason=f"{LIBRARY} is not built for this machine")
OK, BAD_ARGUMENT, BAD_PARAMETER, MEMORY_TOO_SMALL, BAD_CHECKPOINT, JOBS_DIFFER = range(6)
SMALL = Camera(64, 48, 90, 90, 31.5, 23.5, 0, 0, 0, 0)
BLACK = numpy.zeros((48, 64), numpy.uint8)


@pytest.fixture(scope="module")
def library():
    return load(LIBRARY)


@pytest.fixture
def component(library):
    made = Component(library, SMALL)
    yield made
    library.polhode_destroy(made.handle)


def run(*command) -> subprocess.CompletedProcess:
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=300)


# verifies: DEL-01
def test_the_library_has_the_symbols_of_the_header_and_no_others():
    declared = set(re.findall(r"^[\w \*]*?\b(polhode_\w+)\([^)]*\);", HEADER.read_text().replace(",\n", ","), re.MULTILINE))
    nodes = re.findall(r"^(POLHODE_\w+) \{(.*?)^\}", (REPOSITORY / "platform/capi/polhode.map").read_text(), re.MULTILINE | re.DOTALL)
    mapped = {name: node for node, names in nodes for name in re.findall(r"^\s+(polhode_\w+);", names, re.MULTILINE)}
    lines = run("nm", "-D", "--defined-only", LIBRARY).stdout.splitlines()
    exported = {line.split()[-1] for line in lines}
    assert len(declared) > 20 and declared == set(mapped)
    assert exported == {f"{name}@@{node}" for name, node in mapped.items()} | {node for node, _ in nodes}, exported
    assert "libpolhode.so.1" in run("readelf", "-d", LIBRARY).stdout


# verifies: DEL-01
@pytest.mark.parametrize("command", [["gcc", "-std=c11"], ["g++", "-std=c++11"]])
def test_the_header_stands_alone(tmp_path, command):
    source = tmp_path / "one.c"
    source.write_text('#include "polhode.h"\nint main(void) { return polhode_abi() != POLHODE_ABI; }\n')
    strict = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-I", HEADER.parent, "-fsyntax-only"]
    done = run(*command, *strict, *(["-x", "c++"] if command[0] == "g++" else []), source)
    assert done.returncode == 0, done.stderr


def test_structs_have_the_layout_that_python_reads(tmp_path):
    source = tmp_path / "sizes.c"
    source.write_text('#include <stdio.h>\n#include "polhode.h"\nint main(void) { printf("%zu %zu %zu %zu\\n", sizeof(polhode_camera), '
                      'sizeof(polhode_input), sizeof(polhode_output), offsetof(polhode_output, packets)); return 0; }\n')
    assert run("gcc", "-std=c11", "-I", HEADER.parent, source, "-o", tmp_path / "sizes").returncode == 0
    assert [int(word) for word in run(tmp_path / "sizes").stdout.split()] == [c.sizeof(Camera), c.sizeof(Input), c.sizeof(Output), Output.packets.offset]


# verifies: DEL-02
@pytest.mark.parametrize(("name", "settings"), [("default", []), ("jobs_beside", ["jobs.delay_frames=1"])])
def test_a_c_host_gives_the_samples_stream(tmp_path, name, settings):
    done = run(BUILD / "bin/polhode_c_example", SAMPLE, tmp_path / "bus.ccsds", *settings)
    assert done.returncode == 0 and done.stderr == ""
    assert (tmp_path / "bus.ccsds").read_bytes() == (golden.recorded() / f"{name}.ccsds").read_bytes()


# verifies: DEL-02
def test_a_python_host_gives_the_samples_stream(tmp_path):
    done = run(sys.executable, REPOSITORY / "platform/capi/example/polhode_ctypes.py", LIBRARY, SAMPLE, tmp_path / "bus.ccsds")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "bus.ccsds").read_bytes() == (golden.recorded() / "default.ccsds").read_bytes()


@pytest.mark.parametrize(("arguments", "says"), [
    ([], "usage:"), (["NOT_THERE", "bus"], "cannot be opened"), ([SAMPLE, "NOT_THERE/bus"], "cannot be written"),
    ([SAMPLE, "bus", "features.count_max"], "a key, = and a number"), ([SAMPLE, "bus", "features.count=3"], "no such parameter"),
    ([SAMPLE, "bus", "features.count_max=5"], "features.count_max = 5: allowed is a whole number in 50 .. ")])
def test_the_c_example_refuses_in_words(tmp_path, monkeypatch, arguments, says):
    monkeypatch.chdir(tmp_path)
    done = run(BUILD / "bin/polhode_c_example", *arguments)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and says in done.stderr, done.stderr


@pytest.mark.parametrize(("key", "index", "value", "status", "says"), [
    (b"features.count_max", 0, 500.0, OK, ""), (b"features.sigma_px", 0, 0.3, OK, ""), (b"mask.enabled", 0, 0.0, OK, ""),
    (b"motion.mode", 0, 1.0, OK, ""), (b"features.count_max", 0, 500.5, BAD_PARAMETER, "features.count_max = 500.5: allowed is a whole number"),
    (b"features.sigma_px", 0, float("nan"), BAD_PARAMETER, "features.sigma_px = nan: allowed is 0.05 .. 5"),
    (b"features.sigma_px", 1, 0.3, BAD_ARGUMENT, "index out of range"), (b"mask.enabled", 0, 2.0, BAD_PARAMETER, "mask.enabled = 2"),
    (b"seed", 0, 1e300, BAD_PARAMETER, "seed"), (b"sede", 0, 1.0, BAD_ARGUMENT, "no such parameter"), (None, 0, 1.0, BAD_ARGUMENT, "null")])
def test_a_parameter_is_taken_or_refused_with_its_range(library, component, key, index, value, status, says):
    problem = c.create_string_buffer(256)
    assert library.polhode_set_real(component.parameters, key, index, value, problem, 256) == status
    assert says in problem.value.decode()
    short = c.create_string_buffer(b"x" * 7, 8)
    library.polhode_set_real(component.parameters, b"sede", 0, 1.0, short, 5)
    assert short.raw == b"sede\0xx\0"


def test_whole_numbers_are_exact(library, component):
    exact = 2**62 + 1  # no binary64 is
    assert library.polhode_set_whole(component.parameters, b"seed", 0, exact, None, 0) == OK
    assert library.polhode_set_whole(component.parameters, b"seed", 0, -1, None, 0) == BAD_PARAMETER
    assert library.polhode_check(component.parameters, None, c.c_size_t(0)) == OK


def test_memory_that_does_not_do_is_refused(library, component):
    out, problem = c.c_void_p(), c.create_string_buffer(256)
    octets = library.polhode_memory_needed(component.parameters)
    at = (c.addressof(component.memory) + 63) // 64 * 64
    for place, length in ((at, 100), (at, octets - 1), (at + 8, octets)):
        status = library.polhode_create(c.c_void_p(place), c.c_size_t(length), component.parameters, c.byref(out), problem, c.c_size_t(256))
        assert status == MEMORY_TOO_SMALL and problem.value and out.value is None
    assert library.polhode_create(None, c.c_size_t(octets), component.parameters, c.byref(out), None, c.c_size_t(0)) == BAD_ARGUMENT
    with pytest.raises(ValueError, match="camera"):
        Component(library, Camera(0, 48, 90, 90, 31, 23, 0, 0, 0, 0))


@pytest.mark.parametrize("wrong", [{"pixel_bits": 12}, {"stride_octets": 63}, {"width_px": -1}, {"command_count": 1}, {"finished_count": 1},
                                   {"command_count": 65}])
def test_an_input_that_is_not_whole_is_refused_and_nothing_steps(library, component, wrong):
    commands = (Octets * 65)()
    frame = Input(timestamp_ns=1, pixels=BLACK.ctypes.data, width_px=64, height_px=48, pixel_bits=8, stride_octets=64)
    if wrong.get("command_count") == 65:
        frame.commands = commands
    for name, value in wrong.items():
        setattr(frame, name, value)
    assert library.polhode_step(component.handle, c.byref(frame), c.byref(Output())) == BAD_ARGUMENT
    assert library.polhode_step(component.handle, None, c.byref(Output())) == BAD_ARGUMENT
    assert library.polhode_next_step(component.handle) == 0


def test_a_job_that_nobody_issued_is_refused(library, component):
    job = (c.c_void_p * 1)(c.addressof(component.memory))
    frame = Input(timestamp_ns=1, finished=job, finished_count=1)
    assert library.polhode_step(component.handle, c.byref(frame), c.byref(Output())) == JOBS_DIFFER
    assert library.polhode_run_job(None) == BAD_ARGUMENT and library.polhode_next_step(component.handle) == 0


def counter(library, component, name: bytes) -> int:
    value = c.c_uint32()
    assert library.polhode_counter(component.handle, name, c.byref(value)) == OK
    return value.value


def test_frames_that_cannot_be_used_are_counted(library, component):
    assert packets_of(component.step(1_000_000_000, None)) and packets_of(component.step(2_000_000_000, BLACK))
    assert counter(library, component, b"frames_in") == 2 and counter(library, component, b"frames_unreadable") == 1
    assert counter(library, component, b"frames_dark") == 1
    assert library.polhode_counter(component.handle, b"frames", c.byref(c.c_uint32())) == BAD_ARGUMENT


def test_commands_that_are_none_are_answered_by_an_event(library, component):
    damaged = (c.c_uint8 * 12)(*range(12))
    commands = (Octets * 2)(Octets(damaged, 12), Octets(None, 5))
    length = len(packets_of(component.step(1_000_000_000, None)))
    commanded = Component(library, SMALL)
    assert len(packets_of(commanded.step(1_000_000_000, None, commands=commands, command_count=2))) > length
    library.polhode_destroy(commanded.handle)


def test_a_checkpoint_brings_the_counters_back(library, component):
    component.step(1_000_000_000, None)
    octets = library.polhode_checkpoint_octets_max()
    saved, written = (c.c_uint8 * octets)(), c.c_size_t()
    assert library.polhode_save_checkpoint(component.handle, saved, c.c_size_t(octets - 1), c.byref(written)) == MEMORY_TOO_SMALL
    assert library.polhode_save_checkpoint(component.handle, saved, c.c_size_t(octets), c.byref(written)) == OK
    other = Component(library, SMALL)
    assert library.polhode_restore_checkpoint(other.handle, saved, c.c_size_t(written.value - 1)) == BAD_CHECKPOINT
    assert library.polhode_restore_checkpoint(other.handle, saved, written) == OK
    assert counter(library, other, b"frames_unreadable") == 1 and library.polhode_next_step(other.handle) == 1
    assert library.polhode_restore_checkpoint(other.handle, saved, written) == BAD_ARGUMENT  # it has stepped


NOT_KNOWN, BAD_MODEL = 7, 8


def saved_model(library, component) -> bytes:
    octets = library.polhode_model_octets_max()
    model, written = (c.c_uint8 * octets)(), c.c_size_t()
    assert library.polhode_save_model(component.handle, model, c.c_size_t(octets - 1), c.byref(written)) == MEMORY_TOO_SMALL
    status = library.polhode_save_model(component.handle, model, c.c_size_t(octets), c.byref(written))
    assert (status == OK) == (written.value > 0) and status in (OK, NOT_KNOWN)
    return bytes(model[:written.value])


def load_model(library, component, model: bytes) -> tuple[int, str]:
    problem = c.create_string_buffer(256)
    octets = (c.c_uint8 * len(model)).from_buffer_copy(model)
    status = library.polhode_load_model(component.handle, octets, c.c_size_t(len(model)), problem, c.c_size_t(256))
    return status, problem.value.decode()


# verifies: MAP-12, DEL-01
def test_what_the_program_has_learnt_is_given_to_a_host_and_comes_back_the_same(library, component, tmp_path):
    file = tmp_path / "target.model"
    done = run(BUILD / "bin/polhode", "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", SAMPLE,
               "--out", tmp_path / "out", "--save-model", file)
    assert done.returncode == 0, done.stderr
    model = file.read_bytes()
    for wrong, says in ((model[:-1], "cut off or damaged"), (b"x" + model[1:], "no model"), (model[:10], "no model"),
                        (model + b"\0", "cut off or damaged")):
        status, problem = load_model(library, component, wrong)
        assert status == BAD_MODEL and says in problem
    assert saved_model(library, component) == b""
    assert load_model(library, component, model) == (OK, "")
    host = Component(library, SMALL)
    again = saved_model(library, component)
    assert load_model(library, host, again) == (OK, "") and saved_model(library, host) == again
    library.polhode_destroy(host.handle)
    component.step(1_000_000_000, None)
    assert load_model(library, component, model)[0] == BAD_ARGUMENT  # it has stepped
