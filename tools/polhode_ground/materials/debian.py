"""Debian packages behind a program, with what their records say of version and licence."""

import os
import pathlib
import re
import subprocess

from polhode_ground.common.errors import BadInput

from .material import Material

# Header-only, so that no loader names them: what is included from them is compiled into the program.
COMPILED_IN = ("libceres-dev", "libeigen3-dev", "libflann-dev", "nlohmann-json3-dev", "libcli11-dev")
LOADER = re.compile(r"(?:\S+ => )?(/\S+) \(0x")
NEEDED = re.compile(r"\(NEEDED\)\s+Shared library: \[(.+?)\]")
# Debian's short names, where SPDX has another name for the same licence.
SPDX = {
    "apache-2": "Apache-2.0",
    "bsd-2-clause": "BSD-2-Clause",
    "bsd-3-clause": "BSD-3-Clause",
    "bsd-3": "BSD-3-Clause",
    "boost-1.0": "BSL-1.0",
    "cc0": "CC0-1.0",
    "expat": "MIT",
    "gpl-2": "GPL-2.0-only",
    "gpl-2+": "GPL-2.0-or-later",
    "gpl-2.0+": "GPL-2.0-or-later",
    "gpl-3": "GPL-3.0-only",
    "gpl-3+": "GPL-3.0-or-later",
    "lgpl-2+": "LGPL-2.0-or-later",
    "lgpl-2.1": "LGPL-2.1-only",
    "lgpl-2.1+": "LGPL-2.1-or-later",
    "lgpl-3": "LGPL-3.0-only",
    "lgpl-3+": "LGPL-3.0-or-later",
    "mpl-2": "MPL-2.0",
    "zlib": "Zlib",
}
COMMON = re.compile(r"/usr/share/common-licenses/([A-Za-z]+(?:-\d+(?:\.\d+)*)?)")
DOC = pathlib.Path("/usr/share/doc")


def said(*command: object) -> str:
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False).stdout


def libraries_of(program: pathlib.Path) -> list[pathlib.Path]:
    done = subprocess.run(["ldd", program], capture_output=True, text=True, check=False)
    missing = re.findall(r"(\S+) => not found", done.stdout)
    if done.returncode != 0 or missing:
        raise BadInput(f"{program}: {'misses ' + ', '.join(missing) if missing else 'not a program that this machine can load'}")
    return [pathlib.Path(path) for path in LOADER.findall(done.stdout)]


def package_by_library(libraries: list[pathlib.Path]) -> dict[str, str]:
    """By the library's name. Recorded under / or under /usr, by its own path or by that of the file that a link leads to."""
    places = {library: {str(path) for path in (library, library.resolve())} for library in libraries}
    asked = {path.removeprefix("/usr") for paths in places.values() for path in paths}
    lines = said("dpkg-query", "-S", *sorted(asked | {"/usr" + path for path in asked})).splitlines()
    owner = {path.removeprefix("/usr"): packages.split(",")[0] for packages, path in (line.split(": ", 1) for line in lines)}
    found = {
        library.name: next((owner[at] for path in paths if (at := path.removeprefix("/usr")) in owner), "")
        for library, paths in places.items()
    }
    strangers = [name for name, package in found.items() if not package]
    if strangers:
        raise BadInput(f"{', '.join(strangers)}: of no Debian package")
    return found


def copyright_of(package: str) -> str:
    file = DOC / package.split(":")[0] / "copyright"
    return file.read_text(errors="replace") if file.exists() else ""


def licences_in(text: str) -> tuple[str, ...]:
    """By the machine-readable form, else by the common licences that the text names."""
    if text.startswith("Format:"):
        paragraphs = re.split(r"\n\s*\n", text)
        files = [p for p in paragraphs if re.match(r"Files:", p) and not re.match(r"Files:\s*debian/\S*\s*\n(?!\s)", p)]
        found = [m.group(1).strip() for p in files if (m := re.search(r"^License:[ \t]*(.+)$", p, re.MULTILINE))]
    else:
        found = COMMON.findall(text)
    words = [SPDX.get(name.lower(), name) for name in found]
    return tuple(sorted(set(words))) or ("as in the package's copyright file",)


def material(package: str, use: str, direct: bool = True, needs: tuple[str, ...] = ()) -> Material:
    version = said("dpkg-query", "-W", "-f", "${Version}", package)
    return Material(package.split(":")[0], version, licences_in(copyright_of(package)), purl_of(package), use, direct, needs)


def purl_of(package: str) -> str:
    name, version, architecture = said("dpkg-query", "-W", "-f", "${Package} ${Version} ${Architecture}", package).split()
    return f"pkg:deb/debian/{name}@{version}?arch={architecture}&distro=debian-12"


def needed_by(file: pathlib.Path) -> set[str]:
    return set(NEEDED.findall(said("env", "LC_ALL=C", "readelf", "-d", os.path.realpath(file))))


def loaded_by(program: pathlib.Path) -> list[Material]:
    """A row for each package, with the packages that its libraries load."""
    libraries = libraries_of(program)
    package_by_name = package_by_library(libraries)
    files: dict[str, list[pathlib.Path]] = {}
    for path in libraries:
        files.setdefault(package_by_name[path.name], []).append(path)
    asked_for = {package_by_name[name] for name in needed_by(program) if name in package_by_name}
    rows = []
    for package, paths in sorted(files.items()):
        others = {package_by_name[name] for path in paths for name in needed_by(path) if name in package_by_name} - {package}
        rows.append(material(package, "loaded", package in asked_for, tuple(sorted(map(purl_of, others)))))
    return rows


def compiled_in() -> list[Material]:
    return [material(package, "compiled in") for package in COMPILED_IN if said("dpkg-query", "-W", "-f", "${Version}", package)]
