"""The Debian packages that tools/package.sh makes, and what stands in them whether they are built or not."""

import hashlib
import os
import pathlib
import re
import shutil
import subprocess

import pytest
from polhode_ground.checking import golden

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]

PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
PACKAGES = REPOSITORY / "build/packages"
DEBIAN = REPOSITORY / "platform/debian"
NAMES = ("polhode", "libpolhode1", "libpolhode-dev", "polhode-ground")
FILES = {name: next(iter(PACKAGES.glob(f"{name}_*.deb")), None) for name in NAMES}
BUILT = pytest.mark.skipif(None in FILES.values(), reason="no packages in build/packages: tools/package.sh makes them")
RUNS = pytest.mark.skipif(not PROGRAM.exists() or "POLHODE_RUNNER" in os.environ, reason=f"{PROGRAM} is not built for this machine")


def run(*command, **more) -> subprocess.CompletedProcess:
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **more)


def subcommands(*words: str) -> list[str]:
    listed = run(PROGRAM, *words, "--help").stdout.partition("Subcommands:\n")[2]
    return re.findall(r"^  ([a-z]+) ", listed, re.MULTILINE)


@RUNS
def test_the_man_page_has_every_command():
    page = re.sub(r"\\f.|\\", "", (DEBIAN / "polhode.1").read_text())
    commands = [f"{first} {second}" for first in subcommands() for second in subcommands(first) or [""]]
    assert {"replay ", "bus dump", "recording export"} <= set(commands)
    missing = [command for command in commands if not re.search(rf"\b{command.strip()}\b", page)]
    assert not missing, f"platform/debian/polhode.1 lacks {', '.join(missing)}"
    options = re.findall(r"--[a-z]+", run(PROGRAM, "bus", "send", "--help").stdout)
    assert {"--key", "--number", "--wait", "--timeout"} <= set(options)
    assert {"--key", "--number", "--wait", "--timeout"} <= set(re.findall(r"--[a-z]+", page))


def completed(*words: str) -> list[str]:
    script = 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _polhode; printf "%s\\n" "${COMPREPLY[@]}"'
    return run("bash", "-c", script, "bash", DEBIAN / "completion.bash", PROGRAM, *words, cwd=DEBIAN / "ground").stdout.split()


@RUNS
def test_bash_completes_commands_and_options():
    assert set(subcommands()) <= set(completed(""))
    assert completed("rep") == ["replay"]
    assert set(completed("bus", "")) == set(subcommands("bus")) | {"postinst", "prerm"}  # files of the folder, too
    assert completed("replay", "--seq") == ["--sequence"]
    assert completed("replay", "--config", "pre") == ["prerm"]
    assert completed("bus", "send", "udp:1", "noop", "--key", "pre") == ["prerm"]
    assert completed("bus", "send", "udp:1", "noop", "--wait", "s") == ["shm:/"]
    assert {"--key", "--wait"} <= set(completed("bus", "send", "udp:1", "noop", "--"))


def listing(name: str) -> dict[str, str]:
    """Path: mode."""
    rows = [line.split() for line in run("dpkg-deb", "-c", FILES[name]).stdout.splitlines()]
    return {row[5]: row[0] for row in rows}


# verifies: DEL-03, DEL-08
@pytest.mark.further
@BUILT
def test_each_package_has_what_it_is_for():
    program, library, development, ground = (set(listing(name)) for name in NAMES)
    assert {"./usr/bin/polhode", "./etc/polhode/live.toml", "./usr/lib/systemd/system/polhode.service", "./usr/share/man/man1/polhode.1.gz",
            "./usr/share/polhode/default.toml", "./usr/share/bash-completion/completions/polhode"} <= program
    assert any(path.endswith("/libpolhode.so.1") for path in library) and not any(path.endswith("/libpolhode.so") for path in library)
    assert "./usr/include/polhode.h" in development and "./usr/include/polhode/pipeline/component.hpp" in development
    assert any(path.endswith("/libpolhode.so") for path in development) and any(path.endswith("/pkgconfig/polhode.pc") for path in development)
    assert {"./usr/share/polhode/bus/polhode.xtce.xml", "./usr/share/polhode/bus/ccsdspy/motion.csv", "./usr/share/polhode/client/c/polhode_bus.c",
            "./usr/lib/python3/dist-packages/polhode_bus/__init__.py", "./usr/share/polhode/client/python/example.py", "./usr/share/doc/polhode-ground/interface_control.md"} <= ground
    folders = [set(path for path in one if not path.endswith("/")) for one in (program, library, development, ground)]
    assert sum(map(len, folders)) == len(set().union(*folders)), "one file in two packages"
    assert run("dpkg-deb", "-I", FILES["polhode"], "conffiles").stdout == "/etc/polhode/live.toml\n"


# verifies: DEL-04
@pytest.mark.further
@BUILT
def test_what_flies_is_stripped_and_links_no_windows_or_codecs(tmp_path):
    for name in ("polhode", "libpolhode1"):
        assert run("dpkg-deb", "-x", FILES[name], tmp_path).returncode == 0
    flown = [tmp_path / "usr/bin/polhode", *tmp_path.rglob("libpolhode.so.1.*")]
    assert len(flown) == 2
    for file in flown:
        assert file.stat().st_size < 8e6 and ".debug_info" not in run("readelf", "-SW", file).stdout
        needed = run("readelf", "-d", file).stdout
        assert "opencv_core" in needed and not re.search(r"opencv_(?:imgcodecs|highgui|videoio)|libgtk|libQt", needed)
        assert re.search(r"Build ID: [0-9a-f]{40}", run("readelf", "-n", file).stdout)
    assert all(list(PACKAGES.glob(f"{name}-dbgsym_*.ddeb")) for name in ("polhode", "libpolhode1"))


# verifies: DEL-07
@pytest.mark.further
@pytest.mark.parametrize("folder", ["packages", "packages-arm64"])
def test_contents_and_dependencies_are_whole(folder):
    if not any((REPOSITORY / "build" / folder).glob("*.deb")) or None in FILES.values():
        pytest.skip(f"no packages in build/{folder} to compare: tools/package.sh makes them")
    sysroot = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache", "polhode/sysroot-arm64")
    more = ["--database", sysroot / "var/lib/dpkg"] if folder == "packages-arm64" else []
    done = run(REPOSITORY / "tools/check_packages.py", REPOSITORY / "build" / folder, "--like", PACKAGES, *more)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["libpolhode-dev", "libpolhode1", "polhode"]


@pytest.mark.further
@BUILT
@pytest.mark.slow
def test_lintian_finds_no_errors():
    if not shutil.which("lintian"):
        pytest.skip("lintian is not installed: tools/setup.sh packages")
    done = run("lintian", "--allow-root", "--fail-on", "error", *FILES.values(), timeout=300)
    assert done.returncode == 0, done.stdout


# verifies: DEL-03
@pytest.mark.further
@BUILT
@pytest.mark.slow
def test_they_install_run_the_sample_and_leave_nothing_in_a_bare_root():
    if not shutil.which("mmdebstrap") or os.geteuid() != 0:
        pytest.skip("takes root and mmdebstrap: tools/setup.sh packages")
    done = run(REPOSITORY / "hil/bare_root.sh", PACKAGES, timeout=1800)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "nothing of it remains" in done.stdout and "rates printed by the container as user ground" in done.stdout
    recorded = hashlib.sha256((golden.recorded() / "default.ccsds").read_bytes()).hexdigest()
    assert f"sha256 of the sample's stream: {recorded}" in done.stdout


@pytest.mark.further
@BUILT
def test_the_contact_is_one_and_the_same():
    contacts = {run("dpkg-deb", "-f", file, "Maintainer").stdout.strip() for file in FILES.values()}
    assert len(contacts) == 1, contacts
    copyright = run("bash", "-c", 'dpkg-deb --fsys-tarfile "$0" | tar -xO ./usr/share/doc/polhode/copyright', FILES["polhode"]).stdout
    assert f"Upstream-Contact: {contacts.pop()}\n" in copyright and not re.search(r"@\w+@", copyright)


@pytest.mark.slow
def test_a_contact_without_an_address_is_refused(tmp_path):
    done = run("cmake", "--preset", "package", "-B", tmp_path, "-DPOLHODE_PACKAGE_CONTACT=nobody", cwd=REPOSITORY, timeout=300)
    assert done.returncode == 1 and "POLHODE_PACKAGE_CONTACT is 'nobody'; allowed is NAME <ADDRESS>" in " ".join(done.stderr.split())


CONTAINER = (DEBIAN / "Containerfile").read_text()


@pytest.mark.further
@BUILT
def test_the_container_starts_what_the_ground_package_holds():
    assert re.search(r"^FROM debian:bookworm-slim$", CONTAINER, re.MULTILINE)
    started = re.search(r'^ENTRYPOINT \["python3", "([^"]+)"\]$', CONTAINER, re.MULTILINE)[1]
    assert f".{started}" in listing("polhode-ground")
    copied = re.search(r"^COPY (\S+) /pkg/$", CONTAINER, re.MULTILINE)[1]
    assert list(PACKAGES.glob(copied)) == [FILES["polhode-ground"]]


@pytest.mark.further
@BUILT
@pytest.mark.parametrize("able", ["podman", "docker", None])
def test_the_container_is_built_by_the_builder_that_works(tmp_path, able):
    """Stand-ins of both; only one of them, or none, has a service behind it."""
    for name in ("podman", "docker"):
        (tmp_path / name).write_text(f'#!/bin/sh\n[ "$1" != info ] || exit {0 if name == able else 1}\necho {name} "$@"\n')
        (tmp_path / name).chmod(0o755)
    done = run(REPOSITORY / "tools/package.sh", "container", env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"})
    if able:
        assert done.stdout == f"{able} build -f platform/debian/Containerfile -t polhode-ground build/packages\n"
    else:
        assert done.returncode == 2 and done.stderr == "package: neither podman nor docker can build here\n"


def test_a_folder_without_packages_is_refused(tmp_path):
    done = run(REPOSITORY / "hil/bare_root.sh", tmp_path)
    assert done.returncode == 2 and done.stderr == f"bare_root: {tmp_path}: no polhode_*.deb; tools/package.sh makes them\n"
    done = run(REPOSITORY / "tools/package.sh", "chekc")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "allowed: check" in done.stderr
