"""After the seal nothing asks the machine for memory, a thread or a file: the kernel watches, and would end the program."""

import functools
import os

import pytest

TRAPPED = 5
# The everyday run; tools/soak.sh asks for 20,000.
FRAMES = int(os.environ.get("POLHODE_SOAK_FRAMES", "300"))


JOBS = {"within the step": (0, 0), "but windows on a second thread": (0, 1), "on a second thread": (1, 1)}


@pytest.fixture(scope="session")
def run_of(soak):
    """One run for each setting, whatever the order of the tests."""

    @functools.cache
    def call(delay, delay_of_all):
        return soak(FRAMES, "--set", f"jobs.delay_frames={delay}", "--set", f"jobs.delay_of_all_frames={delay_of_all}")

    return call


@pytest.fixture(params=[pytest.param(name, marks=pytest.mark.further if name != "but windows on a second thread" else ()) for name in JOBS])
def run(request, run_of):
    return run_of(*JOBS[request.param])


# verifies: RES-01
@pytest.mark.slow
def test_nothing_was_asked_of_the_machine(run):
    assert run.status == 0, run.err
    assert run.found["trap"], "the kernel did not take the filter: nothing was watched"
    assert run.found["overdrafts"] == 0


@pytest.mark.slow
def test_no_page_was_missing(run):
    if not run.found["locked"]:
        pytest.skip("this user may not lock memory")
    assert run.found["faults_after_seal"] == 0


# verifies: RES-02
@pytest.mark.slow
def test_memory_stays_where_it_is(run):
    """Live blocks breathe with the frame that is being worked on, but they do not grow."""
    blocks = run.found["live_blocks"]
    assert max(blocks[1:]) <= 1.02 * blocks[0] + 50
    octets = run.found["used_octets"]
    assert max(octets[1:]) <= 1.05 * octets[0] + (1 << 20)
    resident = run.found["resident_octets"]
    assert max(resident) - min(resident) <= 64 << 10


@pytest.mark.slow
@pytest.mark.further
def test_a_late_frame_costs_what_an_early_one_does(run):
    if FRAMES < 5000:
        pytest.skip("the map is still growing over so few frames: tools/soak.sh")
    assert run.found["median_step_ms_last_tenth"] <= 1.05 * run.found["median_step_ms_second_tenth"]


@pytest.mark.slow
def test_the_body_is_followed_meanwhile(run):
    assert run.found["poses"] >= 0.9 * run.found["frames"]


# verifies: RES-01
@pytest.mark.parametrize("call", ["mmap", "brk", "open", "thread", "madvise"])
def test_the_trap_would_have_seen_it(soak, call):
    result = soak(1, "--warm-up", "1", "--control", call)
    assert result.status == TRAPPED
    named = {"open": ("open",), "thread": ("mmap", "clone", "mprotect"), "brk": ("brk",)}.get(call, (call,))
    assert any(name in result.err for name in named)
