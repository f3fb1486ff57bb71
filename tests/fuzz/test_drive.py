"""Spoilt inputs to every reader, a few of each; tests/fuzz/drive.py gives as many as are asked for."""

import subprocess
import sys

import pytest
from drive import drive, execute, fault_of, form_of, report
from readers import PROGRAM, REPOSITORY, all_readers

COLMAP = REPOSITORY / ".venv-colmap/bin/python3"

TRIALS = 81  # three of each reader, and of the two of tools/surface.py where pycolmap is installed


# verifies: PRG-06
@pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")
def test_no_reader_fails(tmp_path):
    outcomes = drive(TRIALS, 7, tmp_path)
    assert len({outcome.reader for outcome in outcomes}) == (27 if COLMAP.exists() else 25)
    assert any(outcome.status == 2 for outcome in outcomes) and any(outcome.status == 0 for outcome in outcomes)
    assert not any(outcome.fault for outcome in outcomes), report(outcomes)


@pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")
def test_a_reader_can_be_left_out_and_the_trials_of_the_others_stay(tmp_path):
    every = drive(4, 7, tmp_path / "a")
    fewer = drive(4, 7, tmp_path, leave_out=[every[1].reader])
    assert [(one.trial, one.reader, one.status) for one in fewer] == [(one.trial, one.reader, one.status) for one in every if one.trial != 1]


@pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")
def test_sums_that_are_put_right_are_those_of_the_program(tmp_path):
    """Else every spoilt file would be refused for its sums, and what is behind them never tried."""
    for reader in all_readers(tmp_path):
        if reader.sums is not None:
            made_right = bytearray(reader.good)
            reader.sums(made_right)
            assert made_right == reader.good, reader.name


def test_what_a_fault_is():
    good = b"polhode: /x/input:3: no number\n"
    assert fault_of(2, 0.1, 1000, good, ["input"]) == ""
    assert fault_of(-11, 0.1, 1000, b"", ["input"]) == "status -11"
    assert fault_of(4, 0.1, 1000, b"", ["input"]) == "status 4"
    assert fault_of(0, 21.0, 1000, b"", ["input"]) == "21 s"
    assert fault_of(0, 0.1, 2_000_000, b"", ["input"]) == "2000000 kB"
    assert fault_of(2, 0.1, 1000, b"polhode: no number\n", ["input"]) == "a refusal names the file"
    assert fault_of(2, 0.1, 1000, good + good, ["input"]) == "a refusal is one line"
    assert fault_of(2, 0.1, 1000, b"surface: /x/cloud.ply: no PLY\n", ["cloud.ply"], "surface") == ""
    assert fault_of(2, 0.1, 1000, b"Traceback (most recent call last):\nsurface: cloud.ply\n", ["cloud.ply"], "surface") == "a refusal is one line"


def test_what_sanitizers_find_is_a_fault(tmp_path):
    """A program of one line that reads behind its memory, or adds past the largest number: its status would be 1 by itself. One without a fault."""
    for name, line, fault in (("address", "volatile char *a = (char *)malloc(4); int i = argc + 3; return a[i];", "status 86"),
                              ("undefined", "volatile int most = 2147483647; return most + argc > 0;", "status 86"),
                              ("neither", "volatile char *a = (char *)calloc(4, 1); int i = argc + 2, got = a[i]; free((void *)a); return got;", "")):
        source = tmp_path / f"{name}.c"
        source.write_text(f"#include <stdlib.h>\nint main(int argc, char **argv) {{ (void)argv; {line} }}\n")
        subprocess.run(["cc", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", source, "-o", tmp_path / name], check=True)
        status, seconds, memory_kb, err = execute([str(tmp_path / name)], 20.0)
        assert fault_of(status, seconds, memory_kb, err, ["input"]) == fault, err


def test_a_run_that_waits_for_ever_is_ended():
    status, processor_s, _, _ = execute([sys.executable, "-c", "import time; time.sleep(60)"], 1.0)
    assert status == -9 and processor_s < 1.0


def test_the_form_of_a_refusal_is_without_places_and_values():
    first, second = (form_of(f"polhode: /x/tmp{name}/data.csv:{line}: no number: '{text}'", "/x") for name, line, text in (("ab_1", 3, "1e"), ("q", 17, "")))
    assert first == second == "polhode: data.csv:0: no number: '...'"
