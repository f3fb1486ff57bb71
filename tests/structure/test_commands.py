"""Scripts that are documented as commands are commands: they run by path, on the distribution's Python too, say how they are used, and
refuse what they cannot use in words."""

import os
import pathlib
import re
import subprocess
import sys

import pytest
from source_tree import REPOSITORY, name_of, source_files

SAMPLE = REPOSITORY / "hil/data/sample"
PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))

COMMANDS = [file for file in source_files("hil", "tools", suffixes=(".py",)) if file.read_text().startswith("#!")]

SHELL_COMMANDS = [file for folder in ("tools", "hil") for file in sorted((REPOSITORY / folder).glob("*.sh"))]


def test_commands_are_found_at_all():
    names = {name_of(file) for file in COMMANDS}
    assert {"hil/evaluate.py", "tools/plot_replay.py", "tools/import_sequence.py", "tools/calibrate_camera.py", "tools/sequence_to_mcap.py"} <= names


@pytest.fixture(scope="module")
def other_python(tmp_path_factory):
    """The environment of a shell that is set up for another Python: its packages, its library, the user's own packages."""
    packages = tmp_path_factory.mktemp("packages")
    home = tmp_path_factory.mktemp("home")
    site = home / f".local/lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
    site.mkdir(parents=True)
    for name in ("argparse", "numpy", "cv2", "PIL", "sitecustomize", "usercustomize"):
        for folder in (packages, site):
            (folder / f"{name}.py").write_text(f"raise ImportError('{name} of another Python')\n")
    return {**os.environ, "PYTHONPATH": str(packages), "HOME": str(home), "PYTHONWARNINGS": "error"}


@pytest.mark.parametrize("file", COMMANDS, ids=name_of)
def test_its_help_is_printed_by_its_path(file, tmp_path, other_python):
    assert os.access(file, os.X_OK), f"{name_of(file)} is not executable"
    # The search path is the system's: what a script imports before it has entered the repository's environment is not there.
    done = subprocess.run([file, "--help"], capture_output=True, text=True, cwd=tmp_path, timeout=60,
                          env={**other_python, "PATH": os.defpath, "PYTHONHOME": "/not/there"})
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usage: "), done.stdout
    examples = [line.strip() for line in done.stdout.splitlines()]
    assert any(line.removeprefix("./").startswith(f"{name_of(file)} ") for line in examples), f"{name_of(file)}: --help shows no example\n{done.stdout}"
    assert not list(tmp_path.iterdir())


def test_packages_of_another_python_are_not_used_where_an_interpreter_is_named_either(tmp_path, other_python):
    """It reads the variables before any script: none of the standard library's names is in the way here."""
    (tmp_path / "numpy.py").write_text("raise ImportError('numpy of another Python')\n")
    done = subprocess.run([sys.executable, REPOSITORY / "tools/import_sequence.py", "NOT_THERE", "OUT", "--intrinsics", "1,1,1,1"], capture_output=True,
                          text=True, timeout=60, cwd=tmp_path, env={**other_python, "PYTHONPATH": str(tmp_path)})
    assert done.returncode == 2 and "NOT_THERE: not there" in done.stderr, done.stderr


@pytest.mark.parametrize("file", SHELL_COMMANDS, ids=name_of)
def test_a_shell_command_starts_python_without_other_packages(file):
    lines = [line for line in file.read_text().splitlines() if not line.startswith(("#", "inside ", "set -"))]  # inside a root without variables
    if any(re.search(r"\bpython3?\b|\bblender\b", line) for line in lines):
        assert lines[0].startswith("unset PYTHONPATH PYTHONHOME; export PYTHONNOUSERSITE=1")


@pytest.mark.parametrize("file", SHELL_COMMANDS, ids=name_of)
def test_a_shell_command_says_how_it_is_called(file, tmp_path):
    done = subprocess.run(["bash", file, "--help"], capture_output=True, text=True, cwd=tmp_path, timeout=60)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert f"{name_of(file)}" in done.stdout and not done.stdout.startswith("#"), done.stdout


@pytest.mark.parametrize(("name", "arguments", "says"), [
    ("hil/kill_campaign.py", ["FOLDER"], "is there already"),
    ("hil/kill_campaign.py", ["NOT_THERE", "--kills", "0"], "--kills: 0: out of range, allowed is at least 1"),
    ("hil/seu_campaign.py", ["FOLDER"], "is there already"),
    ("hil/seu_campaign.py", ["NOT_THERE", "--flips", "64,5000"], "5000: out of range, allowed is 0 .. 4096"),
    ("hil/transform.py", [SAMPLE, "FOLDER", "--kind", "jpeg"], "is there already"),
    ("hil/transform.py", [SAMPLE, "NOT_THERE", "--kind", "jpg"], "step 1: kind 'jpg' is none of faults, repeated"),
    ("hil/transform.py", [SAMPLE, "NOT_THERE", "--kind", "jpeg", "--set", "jpeg.quality=0"], "quality = 0: allowed is a whole number in 1 .. 100"),
    ("hil/transform.py", [SAMPLE, "NOT_THERE", "--kind", "faults", "--set", "faults.fraction=nan"], "allowed is a number in 0.0 .. 0.9"),
    ("hil/campaign.py", ["NOT_THERE", "--out", "NOT_THERE"], "No such file"),
    ("hil/campaign.py", [], "PLAN.toml and --out DIR are needed"),
    ("hil/campaign.py", ["--report", "FOLDER"], "campaign.json is missing"),
    ("hil/campaign.py", ["NOT_THERE", "--out", "NOT_THERE", "--workers", "0"], "--workers: 0: out of range, allowed is 1 .. 1024"),
    ("hil/predict.py", [SAMPLE, "NOT_THERE", "--frames", "0"], "--frames: 0: out of range, allowed is at least 1"),
    ("hil/predict.py", [SAMPLE, "NOT_THERE", "--frames", "500"], "has 90 frames, allowed is 1 .. 89"),
    ("tools/first_difference.py", ["FOLDER", "FILE"], "FOLDER: Is a directory"),
    ("tools/first_difference.py", ["FILE", "NOT_THERE"], "NOT_THERE: No such file"),
    ("tools/scale_sequence.py", ["NOT_THERE", "OUT", "--width", "20", "--height", "20"], "NOT_THERE: no sequence"),
    ("tools/scale_sequence.py", [SAMPLE, SAMPLE, "--width", "20", "--height", "20"], "is there already"),
    ("tools/scale_sequence.py", [SAMPLE, "OUT", "--width", "-1", "--height", "20"], "--width: -1: out of range, allowed is 1 .. 8192"),
    ("tools/import_sequence.py", ["NOT_THERE", "OUT"], "NOT_THERE: not there; expected a video"),
    ("tools/import_sequence.py", [SAMPLE], "SEQ is needed, or --intrinsics auto"),
    ("tools/import_sequence.py", [SAMPLE, "OUT", "--step", "0"], "--step: 0: allowed is a whole number of at least 1"),
    ("tools/import_sequence.py", [SAMPLE, "OUT", "--rate-hz", "nan"], "--rate-hz: nan: not a number"),
    ("tools/surface.py", ["NOT_THERE"], "NOT_THERE/cloud.ply: not there"),
    ("tools/surface.py", ["FOLDER"], "FOLDER/cloud.ply: not there"),
    ("tools/sequence_to_mcap.py", ["NOT_THERE", "--out", "OUT"], "NOT_THERE: no such sequence folder"),
    ("tools/sequence_to_mcap.py", [SAMPLE, "--run", "FOLDER", "--out", "OUT"], "FOLDER"),
    ("tools/report.py", ["FOLDER", "--rrd", "OUT"], "holds neither motion.csv nor motion_smoothed.csv"),
    ("tools/report.py", ["NOT_THERE"], "NOT_THERE: no such run folder"),
    ("tools/report.py", ["FOLDER"], "holds neither motion.csv nor motion_smoothed.csv"),
    ("tools/export.py", ["NOT_THERE", "--format", "aem"], "NOT_THERE: no such run folder"),
    ("tools/export.py", ["FOLDER", "--format", "ck"], "FOLDER: holds no motion.csv, and no bus.ccsds with packets of motion"),
    ("tools/export.py", ["FOLDER", "--format", "ck", "--naif-id", "5"], "--naif-id: 5: out of range, allowed is -9999 .. -1"),
    ("tools/export.py", ["FOLDER", "--format", "aem", "--target", "a b"], "'a b': allowed are 1 to 26 of A-Z"),
    ("tools/benchmark_table.py", ["NOT_THERE"], "NOT_THERE: No such file"),
    ("tools/benchmark_table.py", ["FILE"], "not a replay's summary.json"),
    ("tools/junit_totals.py", ["NOT_THERE"], "NOT_THERE: No such file"),
    ("tools/junit_totals.py", ["FILE"], "FILE: not a report"),
    ("tools/junit_totals.py", [], "REPORT.xml"),
    ("tools/requirements_matrix.py", ["--results", "NOT_THERE"], "NOT_THERE: no such folder"),
    ("tools/make_site.py", ["--out", "."], "holds other files"),
    ("tools/check_packages.py", ["FOLDER"], "FOLDER: no packages; tools/package.sh makes them"),
    ("tools/sbom.py", ["--program", "NOT_THERE", "--out", "OUT"], "NOT_THERE: no such program"),
    ("tools/sbom.py", ["--program", "FILE", "--out", "NOT_THERE/OUT"], "NOT_THERE: no such folder"),
    ("tools/sbom.py", ["--program", "FILE", "--out", "OUT"], "not a program that this machine can load"),
    ("tools/plot_masks.py", ["NOT_THERE", SAMPLE], "masks.pgms: not there; replay with --masks"),
    ("tools/plot_masks.py", ["FOLDER", SAMPLE, "--frames", "1,x"], "--frames"),
])
def test_what_it_cannot_use_is_refused_in_words(tmp_path, name, arguments, says):
    (tmp_path / "FOLDER").mkdir()
    (tmp_path / "FILE").write_text("text")
    done = subprocess.run([sys.executable, REPOSITORY / name, *arguments], capture_output=True, text=True, cwd=tmp_path, timeout=60)
    assert done.returncode == 2, done.stderr
    assert says in done.stderr.splitlines()[-1] and "Traceback" not in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"FOLDER", "FILE"} and not list((tmp_path / "FOLDER").iterdir())


@pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")
@pytest.mark.parametrize(("name", "arguments", "says"), [
    ("tools/first_difference.py", ["FILE", "OTHER"], "FILE: holds no packet"),
    ("tools/repeat_replays.py", ["--sequence", "NOT_THERE", "--replays", "1"], "NOT_THERE: no such folder"),
])
def test_the_programs_own_words_are_passed_on(tmp_path, name, arguments, says):
    (tmp_path / "FILE").write_text("text")
    (tmp_path / "OTHER").write_text("other text")
    done = subprocess.run([sys.executable, REPOSITORY / name, *arguments], capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and says in done.stderr, done.stderr


def test_the_virtual_machine_refuses_a_clone_that_its_guest_cannot_see(tmp_path):
    """pytest's own folder lies below /tmp."""
    (tmp_path / "hil").mkdir()
    (tmp_path / "hil/v4l2_vm.sh").write_text((REPOSITORY / "hil/v4l2_vm.sh").read_text())
    done = subprocess.run(["bash", tmp_path / "hil/v4l2_vm.sh"], capture_output=True, text=True, timeout=60)
    if not str(tmp_path.resolve()).startswith("/tmp/"):
        pytest.skip("temporary files are elsewhere")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "lies below /tmp or /run" in done.stderr
