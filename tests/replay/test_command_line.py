"""Arguments, configuration and output folder: refused before start with exit 2, or obeyed."""

import resource
import signal
import subprocess

import pytest
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM, summary


def refused(result, *parts):
    assert result.status == 2, result.err
    lines = result.err.strip().splitlines()
    assert len(lines) == 1, result.err
    for part in parts:
        assert part in lines[0], lines[0]


def test_help_and_version(program):
    assert program("--version").out == "polhode 0.1.0\n"
    text = program("--help")
    assert text.status == 0
    for command in ("replay", "check", "bus"):
        assert command in text.out
        assert program(command, "--help").status == 0
    for option in ("--config", "--sequence", "--out", "--realtime", "--set"):
        assert option in program("replay", "--help").out


# verifies: PRG-01
@pytest.mark.parametrize(
    "arguments",
    [[], ["fly"], ["replay"], ["replay", "--config"], ["replay", "--bogus"], ["bus"], ["bus", "dump"], ["check"]],
)
def test_unusable_arguments(program, arguments):
    refused(program(*arguments), "polhode: ")


def refused_by_check_and_replay(program, config, sequence, text, says):
    config.write_text(text)
    out = config.parent / "out"
    refused(program("check", "--config", config), says)
    refused(program("replay", "--config", config, "--sequence", sequence.path, "--out", out), says)
    assert not out.exists()


# verifies: PRG-01
@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[features]\ncount_max = 5000\n", "own.toml:2: features.count_max = 5000: out of range, allowed 50 .. 1000"),
        ("[features]\ncount_max = 'many'\n", "own.toml:2: features.count_max = 'many': wrong type, allowed is a whole number"),
        ("[features]\ncount_maximum = 5\n", "own.toml:2: features.count_maximum: unknown key; did you mean features.count_max?"),
        ("[features\n", "own.toml:1: "),
        ("[scale]\nknown_length_m = 1.0\n", "own.toml: scale.points_px is missing"),
    ],
)
def test_unusable_configuration(program, tmp_path, sequence, text, says):
    refused_by_check_and_replay(program, tmp_path / "own.toml", sequence, text, says)


def test_absent_configuration(program):
    refused(program("check", "--config", "/nowhere/own.toml"), "/nowhere/own.toml: cannot be read: No such file")


@pytest.mark.parametrize("command", ["check", "replay", "run"])
def test_a_folder_is_no_configuration(program, tmp_path, sequence, command):
    arguments = ["--sequence", sequence.path, "--out", tmp_path / "out"] if command == "replay" else []
    refused(program(command, "--config", tmp_path, *arguments), f"{tmp_path}: not a regular file")
    assert not (tmp_path / "out").exists()


def test_settings_are_checked_like_the_file(program):
    def check(*settings):
        return program("check", "--config", DEFAULTS, *(part for setting in settings for part in ("--set", setting)))

    refused(check("features.count_max=5000"), "--set features.count_max=5000: features.count_max = 5000: out of range")
    refused(check("featurs.count_max=500"), "unknown key; did you mean features.count_max?")
    refused(check("features.count_max"), "allowed is key=value")
    good = check("features.count_max=500", "scale.known_length_m=0.6", "scale.points_px=[[812.0,400.5],[1010.2,377.9]]",
                 "scale.frame_timestamp_ns=1700000000000000000")
    assert good.status == 0, good.err
    assert "[[812.0, 400.5], [1010.2, 377.9]]" in good.out


def test_check_prints_every_key_with_value_range_and_origin(program, tmp_path):
    config = tmp_path / "own.toml"
    config.write_text("[features]\ncount_max = 321\n")
    lines = program("check", "--config", config).out.splitlines()
    row = next(line for line in lines if line.startswith("features.count_max"))
    assert row.split() == ["features.count_max", "321", "50", "..", "1000", f"{config}:2"]
    assert next(line for line in lines if line.startswith("seed")).split()[-1] == "default"
    assert any(line.startswith("config hash: ") and len(line.split()[-1]) == 64 for line in lines)


def test_check_with_a_sequence_validates_it_too(program, sequence):
    good = program("check", "--config", DEFAULTS, "--sequence", sequence.path)
    assert good.status == 0 and "sequence: 3 frames" in good.out and "memory of the component: " in good.out
    (sequence.camera / "data.csv").write_text("1,a\n1,b\n")
    refused(program("check", "--config", DEFAULTS, "--sequence", sequence.path), "data.csv:2: timestamp [ns]: 1 repeats")


# verifies: PRG-05
def test_default_toml_is_complete_and_holds_the_defaults(program):
    assert DEFAULTS.read_text() == program("check", "--defaults").out


def test_the_field_table_has_the_parameters_that_commands_may_change(program):
    assert (DEFAULTS.parent / "bus/parameters.toml").read_text() == program("check", "--bus-parameters").out


# verifies: PRG-04
def test_output_folder_of_somebody_else_is_left_alone(replay, sequence, tmp_path):
    folder = tmp_path / "precious"
    folder.mkdir()
    (folder / "motion.csv").write_text("mine")
    refused(replay(sequence.path, out=folder), "precious: holds files that no replay wrote")
    assert [file.name for file in folder.iterdir()] == ["motion.csv"]
    assert (folder / "motion.csv").read_text() == "mine"


def test_output_folder_of_an_earlier_run_is_used_again_and_other_files_stay(replay, sequence, tmp_path):
    assert replay(sequence.path).status == 0
    (tmp_path / "out/notes.txt").write_text("mine")
    (tmp_path / "out/summary.json").write_text("old")
    assert replay(sequence.path).status == 0
    assert summary(tmp_path / "out")["program"] == "polhode"
    assert (tmp_path / "out/notes.txt").read_text() == "mine"


def test_a_refused_run_leaves_the_results_of_an_earlier_one(replay, sequence, tmp_path):
    assert replay(sequence.path).status == 0
    before = (tmp_path / "out/motion.csv").read_bytes()
    refused(replay(sequence.path, "--set", "transport.send=['file:/nowhere/x']"), "/nowhere/x")
    assert (tmp_path / "out/motion.csv").read_bytes() == before


def test_what_cannot_be_read_is_not_taken_for_absent(replay, sequence, tmp_path):
    refused(replay(sequence.path, "--commands", tmp_path), f"{tmp_path}: not a regular file")
    (sequence.path / "servicer_attitude.csv").mkdir()
    refused(replay(sequence.path), "servicer_attitude.csv: not a regular file")


def test_output_folder_that_cannot_be_made(replay, sequence, tmp_path):
    (tmp_path / "file").write_text("")
    refused(replay(sequence.path, out=tmp_path / "file"), "file: exists and is not a folder")
    refused(replay(sequence.path, out=tmp_path / "file/below"), "below: cannot be created: Not a directory")
    refused(replay(sequence.path, out="/proc/polhode"), "/proc/polhode: cannot be created")


def test_output_that_fails_during_the_run_is_exit_1(sequence, tmp_path):
    """A limit on the size of files stands for a full disk."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))

    done = subprocess.run(
        [PROGRAM, "replay", "--config", DEFAULTS, "--sequence", sequence.path, "--out", tmp_path / "out"],
        capture_output=True, text=True, preexec_fn=limit, restore_signals=False, check=False)
    assert done.returncode == 1
    assert "cannot be written: File too large" in done.stderr
    assert str(tmp_path / "out") in done.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["fly"], "polhode: unknown command 'fly'; allowed are replay, run, check, bus, camera, recording"),
        (["bus", "fly"], "polhode: bus: unknown command 'fly'; allowed are follow, send, dump"),
        (["replay"], "polhode: --config is required (polhode replay --help shows the usage)"),
        (["bus", "dump"], "(polhode bus dump --help shows the usage)"),
    ],
)
def test_misuse_is_told_by_the_command_that_is_meant(program, arguments, says):
    refused(program(*arguments), says)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[device]\nsorce = '/dev/video0'\n", "live.toml:2: device.sorce: unknown key"),
        ("[run]\ncores = 5\n", "live.toml:2: run.cores: unknown key"),
        ("[transport]\nsend = ['10015']\n", "transport.send: address '10015': its kind is missing"),
        ("[commands]\nfile = '/nowhere/commands.txt'\n", "/nowhere/commands.txt: cannot be read"),
    ],
)
def test_check_and_replay_read_what_is_not_the_estimators(program, tmp_path, sequence, text, says):
    refused_by_check_and_replay(program, tmp_path / "live.toml", sequence, text, says)


def test_check_opens_what_a_run_writes_to_and_commands(program, tmp_path):
    config = tmp_path / "live.toml"
    config.write_text(f"[run]\ncheckpoint = '{tmp_path}'\n")
    refused(program("check", "--config", config), f"run.checkpoint: {tmp_path}: is a folder; allowed is a file's name")
    commands = tmp_path / "commands.txt"
    commands.write_text("5 noop\n4 noop\n")
    config.write_text(f"[commands]\nfile = '{commands}'\n")
    refused(program("check", "--config", config), "commands.txt:2: time decreases")


def test_check_prints_the_machines_keys_too(program, tmp_path):
    config = tmp_path / "live.toml"
    config.write_text("[device]\nbuffers = 8\n[run]\ncore = 1\n[recording]\nslots = 9\n[transport]\nsend = ['udp:10015', 'shm:/a']\n")
    checked = program("check", "--config", config)
    assert checked.status == 0, checked.err
    rows = dict(line.split(None, 1) for line in checked.out.splitlines() if "." in line.split(" ", 1)[0])
    assert rows["device.buffers"].split() == ["8", "2", "..", "32"]
    assert rows["run.core"].split()[0] == "1" and rows["recording.slots"].split()[0] == "9"
    assert rows["transport.send"] == "udp:10015, shm:/a"
    assert rows["transport.receive"] == rows["commands.file"] == "-"
