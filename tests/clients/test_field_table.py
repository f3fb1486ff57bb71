"""What is generated from the field table is up to date, and the clients' examples are short and run."""

import subprocess
import sys

import pytest
from flights import CLIENT, REPOSITORY
from polhode_ground.busgen.table import TableError, read_table


# verifies: BUS-07
def test_generated_files_are_up_to_date():
    done = subprocess.run([sys.executable, REPOSITORY / "tools/generate_bus.py", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


# verifies: BUS-07
def test_the_interface_control_document_names_every_packet_and_command(tmp_path):
    command = [sys.executable, REPOSITORY / "tools/generate_bus.py", "--document"]
    done = subprocess.run([*command, tmp_path / "interface.md"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text, table = (tmp_path / "interface.md").read_text(), read_table(REPOSITORY / "config/bus")
    assert all(f"| {field.name} |" in text for packet in table.packets for field in packet.fields)
    assert all(f" {command.name.upper()}, " in text for command in table.commands)
    done = subprocess.run([*command, tmp_path / "absent/interface.md"], capture_output=True, text=True)
    assert done.returncode == 2 and "absent" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("old", "new"),
    [('name = "frame", type = "u32"', 'name = "frame", type = "u33"'),
     ('valid = "pose"', 'valid = "posture"'),
     ('  { name = "features", type = "u16"', '  { name = "extra", type = "u8", help = "" },\n  { name = "features", type = "u16"'),
     ('apid = 1\n', 'apid = 0\n'),
     ('layout_version = 3', 'layout_version = 4')])
def test_a_table_that_contradicts_itself_is_refused(tmp_path, old, new):
    for file in (REPOSITORY / "config/bus").glob("*.toml"):
        text = file.read_text()
        (tmp_path / file.name).write_text(text.replace(old, new, 1) if file.name == "telemetry.toml" else text)
    with pytest.raises(TableError):
        read_table(tmp_path)


@pytest.mark.parametrize(
    ("old", "new"),
    [("after {poses} poses", "after {pose} poses"),
     ('name = "poses", type = "u32"', 'name = "poses", type = "u33"'),
     ('name = "keyframes", type = "u32"', 'name = "landmarks", type = "u32"'),
     ('[{ name = "poses", type = "u32" }]', '[{ name = "poses", type = "u32" }, { name = "a", type = "u8" }, { name = "b", type = "u8" }]')])
def test_an_event_whose_arguments_contradict_its_text_or_packet_is_refused(tmp_path, old, new):
    for file in (REPOSITORY / "config/bus").glob("*.toml"):
        text = file.read_text()
        assert file.name != "events.toml" or old in text
        (tmp_path / file.name).write_text(text.replace(old, new, 1) if file.name == "events.toml" else text)
    with pytest.raises(TableError):
        read_table(tmp_path)


@pytest.mark.parametrize("example", ["c/example.c", "python/example.py"])
def test_examples_are_short(example):
    assert len((CLIENT / example).read_text().splitlines()) <= 30


def expected_lines(flight) -> list[str]:
    return ["frame {}: {:.5f} {:.5f} {:.5f} rad/s".format(p.frame, *p.w_T_rad_s) for p in flight.packets if p.name == "motion" and p.rate_valid]


# verifies: GND-01
def test_the_c_example_builds_without_anything_else_and_reads_a_flight(flight, tmp_path):
    sources = [str(file) for file in sorted((CLIENT / "c").glob("*.c"))]
    subprocess.run(["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-O1", "-o", tmp_path / "example", *sources], check=True)
    done = subprocess.run([tmp_path / "example", f"file:{flight.file}"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [*expected_lines(flight), f"{len(flight.packets)} packets, 0 missing"]


# verifies: GND-01
def test_the_python_example_reads_a_flight(flight):
    done = subprocess.run([sys.executable, "example.py", f"file:{flight.file}"], cwd=CLIENT / "python", capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [*expected_lines(flight), "0 packets missing"]
