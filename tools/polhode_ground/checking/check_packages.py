"""Checks the Debian packages of a folder without installing them, so those for another architecture, too.

For every package:
  - its programs, libraries and static archives are of its architecture, and without debug symbols
  - each program or library has its debug symbols in the package NAME-dbgsym, by its build id
  - the package of every library that it needs is among its dependencies
With --like, for every package there that is not for all architectures:
  - the same files, apart from the name of the architecture's folder, and the same scripts and conffiles
  - the same version, section, maintainer and description, and dependencies on the same packages

Examples:
  tools/check_packages.py build/packages
  tools/check_packages.py build/packages-arm64 --like build/packages --database ~/.cache/polhode/sysroot-arm64/var/lib/dpkg
"""

import argparse
import dataclasses
import pathlib
import re
import subprocess
import sys
import tempfile

from polhode_ground.common.errors import BadInput
from polhode_ground.common.venv import run_main

# Debian's name of an architecture: readelf's name of it, and the folder of its libraries.
MACHINES = {"amd64": ("Advanced Micro Devices X86-64", "x86_64-linux-gnu"), "arm64": ("AArch64", "aarch64-linux-gnu")}
SAME_FIELDS = ("Version", "Section", "Priority", "Maintainer", "Description")
OF_ONE_BUILD = ("control", "md5sums")  # control files that differ by architecture


def said(*command: object) -> str:
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False, env={"LC_ALL": "C", "PATH": "/usr/bin:/bin"}
    )
    return done.stdout


@dataclasses.dataclass
class Package:
    file: pathlib.Path
    fields: dict[str, str]
    tree: pathlib.Path  # its files, unpacked
    control: pathlib.Path  # its control files

    @property
    def name(self) -> str:
        return self.fields["Package"]

    @property
    def architecture(self) -> str:
        return self.fields["Architecture"]

    def paths(self) -> set[str]:
        folder = MACHINES[self.architecture][1]
        return {
            str(path.relative_to(self.tree)).replace(folder, "ARCHITECTURE")
            for path in self.tree.rglob("*")
            if path.is_symlink() or not path.is_dir()
        }

    def depends(self) -> set[str]:
        return {re.split(r"[ (|:]", one.strip())[0] for one in self.fields.get("Depends", "").split(",") if one.strip()}

    def starting_with(self, magic: bytes) -> list[pathlib.Path]:
        files = sorted(path for path in self.tree.rglob("*") if path.is_file() and not path.is_symlink())
        return [file for file in files if file.open("rb").read(len(magic)) == magic]


def read_package(file: pathlib.Path, work: pathlib.Path) -> Package:
    text = said("dpkg-deb", "-f", file)
    fields = dict(re.findall(r"^(\S+): (.*(?:\n .*)*)", text, re.MULTILINE))
    if not {"Package", "Version", "Architecture"} <= fields.keys():
        raise BadInput(f"{file}: not a Debian package")
    if fields["Architecture"] not in (*MACHINES, "all"):
        raise BadInput(f"{file}: architecture {fields['Architecture']}; allowed: {', '.join(MACHINES)}, all")
    at = work / file.name
    at.mkdir(parents=True)
    for part, folder in (("-x", "tree"), ("-e", "control")):
        done = subprocess.run(["dpkg-deb", part, file, at / folder], capture_output=True, text=True, check=False)
        if done.returncode:
            raise BadInput(f"{file}: {done.stderr.strip().splitlines()[-1]}")
    return Package(file, fields, at / "tree", at / "control")


def packages_in(folder: pathlib.Path, work: pathlib.Path) -> dict[str, Package]:
    """Those of an architecture."""
    files = sorted(folder.glob("*.deb"))
    if not files:
        raise BadInput(f"{folder}: no packages; tools/package.sh makes them")
    packages = (read_package(file, work) for file in files)
    return {package.name: package for package in packages if package.architecture != "all"}


def wrong_code(package: Package, debug: set[str]) -> list[str]:
    """Of programs, libraries and archives, by readelf. DEBUG: files of debug packages, by path."""
    found = []
    machine = MACHINES[package.architecture][0]
    for file in package.starting_with(b"\x7fELF") + package.starting_with(b"!<arch>\n"):
        name = f"{package.name}: {file.relative_to(package.tree)}"
        others = set(re.findall(r"Machine: +(.+)", said("readelf", "-hW", file))) ^ {machine}
        if others:
            found.append(f"{name}: not of {package.architecture} alone: {', '.join(sorted(others))}")
        if ".debug_info" in said("readelf", "-SW", file):
            found.append(f"{name}: has debug symbols")
    for file in package.starting_with(b"\x7fELF"):
        name = f"{package.name}: {file.relative_to(package.tree)}"
        build_id = re.search(r"Build ID: ([0-9a-f]{2})([0-9a-f]+)", said("readelf", "-n", file))
        if " .symtab " in said("readelf", "-SW", file):
            found.append(f"{name}: not stripped")
        if not build_id or f"usr/lib/debug/.build-id/{build_id[1]}/{build_id[2]}.debug" not in debug:
            found.append(f"{name}: its debug symbols are in no package {package.name}-dbgsym")
    return found


def debug_files(folder: pathlib.Path, name: str) -> set[str]:
    return {
        path
        for file in folder.glob(f"{name}-dbgsym_*.ddeb")
        for path in re.findall(r" \./(\S+\.debug)$", said("dpkg-deb", "-c", file), re.MULTILINE)
    }


def needed_libraries(package: Package) -> set[str]:
    return {
        name for file in package.starting_with(b"\x7fELF") for name in re.findall(r"\(NEEDED\).*\[(.+?)\]", said("readelf", "-dW", file))
    }


def wrong_dependencies(package: Package, everything: dict[str, Package], database: pathlib.Path) -> list[str]:
    """Libraries that no dependency brings: of packages in DATABASE or of EVERYTHING that is packaged here."""
    needed = needed_libraries(package)
    if not needed:
        return []
    folder = MACHINES[package.architecture][1]
    lines = said("dpkg-query", f"--admindir={database}", "--search", *(f"*/lib/{folder}/{name}" for name in sorted(needed))).splitlines()
    owners = {
        name: {other.name for other in everything.values() if any(path.endswith(f"/{name}") for path in other.paths())} for name in needed
    }
    for names, path in (line.split(": ", 1) for line in lines):
        owners[path.rsplit("/", 1)[1]] |= {name.split(":")[0] for name in names.split(", ")}
    return [
        f"{package.name}: needs {name}, which {'is in ' + ', '.join(sorted(owners[name])) + ', no dependency' if owners[name] else 'no package has'}"
        for name in sorted(needed)
        if not owners[name] & (package.depends() | {package.name})
    ]


def differences(package: Package, other: Package) -> list[str]:
    found = [
        f"{package.name}: {path}: only in {one.file}"
        for one, two in ((package, other), (other, package))
        for path in sorted(one.paths() - two.paths())
    ]
    found += [
        f"{package.name}: other {field} than {other.file}" for field in SAME_FIELDS if package.fields.get(field) != other.fields.get(field)
    ]
    for name in sorted(package.depends() ^ other.depends()):
        found.append(f"{package.name}: {name}: a dependency only of {(package if name in package.depends() else other).file}")
    texts = [{file.name: file.read_bytes() for file in one.control.iterdir() if file.name not in OF_ONE_BUILD} for one in (package, other)]
    found += [
        f"{package.name}: other {name} than {other.file}"
        for name in sorted(texts[0].keys() | texts[1].keys())
        if texts[0].get(name) != texts[1].get(name)
    ]
    return found


def check(folder: pathlib.Path, like: pathlib.Path | None, database: pathlib.Path) -> list[str]:
    with tempfile.TemporaryDirectory() as work:
        packages = packages_in(folder, pathlib.Path(work) / "these")
        found = []
        for package in packages.values():
            found += wrong_code(package, debug_files(folder, package.name)) + wrong_dependencies(package, packages, database)
            print(
                f"{package.name} {package.fields['Version']} {package.architecture}: {len(package.paths())} files, "
                f"{len(needed_libraries(package))} libraries needed, {len(package.depends())} dependencies"
            )
        others = packages_in(like, pathlib.Path(work) / "those") if like else {}
        for name, other in others.items():
            found += differences(packages[name], other) if name in packages else [f"{name}: not in {folder}"]
        return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--like", type=pathlib.Path, metavar="FOLDER", help="packages of another architecture that these shall equal")
    parser.add_argument(
        "--database",
        type=pathlib.Path,
        metavar="DIR",
        default=pathlib.Path("/var/lib/dpkg"),
        help="dpkg's, with the packages of the libraries; default: this machine's",
    )
    arguments = parser.parse_args()
    if not (arguments.database / "status").is_file():
        raise BadInput(f"--database: {arguments.database}: no database of dpkg; for arm64, tools/setup.sh arm64 makes one")
    found = check(arguments.folder, arguments.like, arguments.database)
    for one in found:
        print(f"check_packages: {one}", file=sys.stderr)
    return 1 if found else 0


def command() -> None:
    run_main(main, "check_packages")
