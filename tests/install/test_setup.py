"""tools/setup.sh and what calls it, on a made-up machine: stand-ins of dpkg, apt and pip write down what they are asked for."""

import os
import pathlib
import shutil
import subprocess

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
COMMANDS = ("bash", "sh", "dirname", "sed", "cmp", "cp", "env", "rm", "mkdir", "cat")
DPKG = """#!/bin/sh
# dpkg-query -W -f FORMAT PACKAGE
grep -qx "$4" "$MACHINE/installed" 2>/dev/null && printf installed
"""
APT = """#!/bin/sh
echo "apt-get $*" >> "$MACHINE/calls"
[ "$1" = install ] || exit 0
[ ! -e "$MACHINE/offline" ] || { echo "E: no network" >&2; exit 100; }
shift
for word in "$@"; do case $word in -*) ;; *) echo "$word" >> "$MACHINE/installed" ;; esac; done
case "$*" in *blender*) printf '#!/bin/sh\\necho "blender $*" >> "$MACHINE/calls"\\n' > "$MACHINE/bin/blender"; chmod +x "$MACHINE/bin/blender" ;; esac
"""


@pytest.fixture
def machine(tmp_path):
    """A machine with nothing installed, and a copy of the scripts on it; root unless bin/id says otherwise."""
    (tmp_path / "bin").mkdir()
    for name in (*COMMANDS, "grep", "chmod"):
        (tmp_path / "bin" / name).symlink_to(shutil.which(name))
    for name, text in (("dpkg-query", DPKG), ("apt-get", APT), ("id", "#!/bin/sh\necho 0\n")):
        write_program(tmp_path / "bin" / name, text)
    for name in ("tools/setup.sh", "tools/requirements.txt", "tools/requirements-tests.txt", "tools/requirements-campaign.txt",
                 "tools/requirements-colmap.txt", "tools/pyproject.toml", "platform/transport/client/python/pyproject.toml", "hil/render_scene.sh"):
        (tmp_path / "house" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(REPOSITORY / name, tmp_path / "house" / name)
    return tmp_path


def write_program(path, text):
    path.unlink(missing_ok=True)
    path.write_text(text)
    path.chmod(0o755)


def call(machine, script, *arguments):
    environment = {"PATH": str(machine / "bin"), "MACHINE": str(machine), "HOME": os.environ.get("HOME", "/")}
    return subprocess.run([machine / "house" / script, *arguments], capture_output=True, text=True, env=environment)


def calls(machine):
    path = machine / "calls"
    return path.read_text().splitlines() if path.exists() else []


def test_the_renderer_is_installed_once(machine):
    (machine / "installed").write_text("python3-numpy\n")
    first = call(machine, "tools/setup.sh", "renderer")
    assert first.returncode == 0 and "installing blender" in first.stdout
    assert calls(machine)[-1] == "apt-get install -y -q --no-install-recommends blender"
    before = calls(machine)
    again = call(machine, "tools/setup.sh", "renderer")
    assert again.returncode == 0 and "all 2 are installed" in again.stdout and calls(machine) == before


def test_rendering_installs_what_it_needs_and_goes_on(machine):
    done = call(machine, "hil/render_scene.sh", "scene.toml", "out", "--check")
    assert done.returncode == 0, done.stderr
    assert "blender is not installed" in done.stderr and done.stdout == ""
    assert calls(machine)[-1].startswith("blender --background") and calls(machine)[-1].endswith("scene.toml out --check")


def test_rendering_says_what_to_do_where_it_can_not_install(machine):
    (machine / "offline").touch()
    done = call(machine, "hil/render_scene.sh", "scene.toml", "out")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].endswith("apt-get install --no-install-recommends blender python3-numpy")


def test_who_may_not_install_is_told_what_is_missing(machine):
    write_program(machine / "bin/id", "#!/bin/sh\necho 1000\n")
    done = call(machine, "tools/setup.sh", "renderer")
    assert done.returncode == 1 and done.stderr == "setup: run as root or install sudo; missing: blender python3-numpy\n"
    assert calls(machine) == []


def test_an_unknown_part_is_refused_in_one_line(machine):
    done = call(machine, "tools/setup.sh", "colmpa")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "colmap" in done.stderr
    assert calls(machine) == []


def stand_in_environment(machine, name):
    venv = machine / "house" / name
    (venv / "bin").mkdir(parents=True)
    for program in ("python", "pip"):
        write_program(venv / "bin" / program, f'#!/bin/sh\necho "{program} $*" >> "$MACHINE/calls"\n')
    return venv


def test_the_program_needs_less_than_its_tests(machine):
    stand_in_environment(machine, ".venv")
    assert call(machine, "tools/setup.sh").returncode == 0
    asked = " ".join(calls(machine))
    assert " libceres-dev " in asked and " cmake " in asked and "-r tools/requirements.txt" in asked
    for word in ("clang-tidy", "valgrind", "libgtest-dev", "requirements-tests", "requirements-campaign"):
        assert word not in asked, word
    assert call(machine, "tools/setup.sh", "tests").returncode == 0
    asked = " ".join(calls(machine)[-4:])
    for word in ("clang-tidy", "valgrind", "libgtest-dev", "requirements-tests", "requirements-campaign"):
        assert word in asked, word
    assert " libceres-dev " not in asked


def test_an_environment_that_is_up_to_date_is_left_alone(machine):
    (machine / "installed").write_text("python3\npython3-venv\n")
    stand_in_environment(machine, ".venv-colmap")
    assert call(machine, "tools/setup.sh", "colmap").returncode == 0
    assert calls(machine) == ["python -m pip install --disable-pip-version-check --progress-bar off -r tools/requirements-colmap.txt"]
    again = call(machine, "tools/setup.sh", "colmap")
    assert "up to date" in again.stdout and len(calls(machine)) == 1
    (machine / "house/tools/requirements-colmap.txt").write_text("pycolmap==9\n")
    assert call(machine, "tools/setup.sh", "colmap").returncode == 0 and len(calls(machine)) == 2
