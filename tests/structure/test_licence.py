"""Every file says whose it is and what may be done with it; what is used of others is named, with its licence."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from source_tree import REPOSITORY

PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
REUSE = pathlib.Path(sys.executable).parent / "reuse"
BUILT_HERE = pytest.mark.skipif(not PROGRAM.exists() or "POLHODE_RUNNER" in os.environ, reason=f"{PROGRAM} is not built for this machine")
TAG = "SPDX-License-" + "Identifier:"  # in two, or it would be taken for this file's own
# As on a machine without libmagic.
ENVIRONMENT = {**os.environ, "REUSE_ENCODING_MODULE": "charset_normalizer"}
IN_GIT = pytest.mark.skipif(not (REPOSITORY / ".git").exists() or not shutil.which("git"), reason="not a clone, or no git: what is generated cannot be told from what is kept")


# verifies: DEL-05
@IN_GIT
def test_every_file_has_a_licence_and_its_text_is_here():
    done = subprocess.run([REUSE, "--root", REPOSITORY, "lint", "--lines"], capture_output=True, text=True, timeout=120, env=ENVIRONMENT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_file_without_a_licence_is_found(tmp_path):
    shutil.copy(REPOSITORY / "REUSE.toml", tmp_path)
    shutil.copytree(REPOSITORY / "LICENSES", tmp_path / "LICENSES")
    for name, text in (("hil/v4l2/filecam/a.h", "int a;\n"), ("fsw/a.h", f"/* {TAG} MIT */\n"), ("fsw/b.h", "int b;\n")):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    lint = [REUSE, "--root", tmp_path, "lint", "--lines"]
    assert subprocess.run(lint, capture_output=True, timeout=60, env=ENVIRONMENT).returncode == 0
    (tmp_path / "vendored").mkdir()
    (tmp_path / "vendored/b.h").write_text("int c;\n")
    done = subprocess.run(lint, capture_output=True, text=True, timeout=60, env=ENVIRONMENT)
    assert done.returncode == 1 and "vendored/b.h" in done.stdout


def test_the_whole_is_apache_and_the_kernel_module_gpl():
    licence = (REPOSITORY / "LICENSE").read_text()
    assert "Apache License" in licence and licence == (REPOSITORY / "LICENSES/Apache-2.0.txt").read_text()
    module = [file for file in (REPOSITORY / "hil/v4l2/filecam").iterdir() if file.suffix in (".c", ".h")]
    assert len(module) >= 5
    assert all(f"{TAG} GPL-2.0-only" in file.read_text().split("\n")[0] for file in module)


@pytest.fixture(scope="module")
def bill(tmp_path_factory):
    file = tmp_path_factory.mktemp("bill") / "bill.json"
    done = subprocess.run([sys.executable, REPOSITORY / "tools/sbom.py", "--program", PROGRAM, "--out", file], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return file.read_text()


@BUILT_HERE
def test_the_bill_of_materials_is_of_its_form(bill):
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(bill) is None
    components = json.loads(bill)["components"]
    assert all(one["version"] and one["licenses"] for one in components)


def installed_version(package: str) -> str:
    return subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True, check=True).stdout


# verifies: DEL-05
@BUILT_HERE
def test_the_bill_holds_every_library_and_every_requirement(bill):
    rows = {one["name"]: one for one in json.loads(bill)["components"]}
    loaded = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
    known = {"libopengv.so.1.0": "libopengv1", "libopencv_core.so.406": "libopencv-core406", "libtbb.so.12": "libtbb12", "libc.so.6": "libc6"}
    for library, package in known.items():
        assert library in loaded
        assert rows[package]["version"] == installed_version(package)
    counted = {pathlib.Path(path).resolve() for path in re.findall(r"(/\S+) \(0x", loaded)}
    assert 30 < sum(one["properties"][0]["value"] == "loaded" for one in rows.values()) <= len(counted)
    for file in (REPOSITORY / "tools").glob("requirements*.txt"):
        for name, version in re.findall(r"^([\w.-]+)(?:\[.*\])?==(\S+)", file.read_text(), re.MULTILINE):
            assert rows[re.sub(r"[-_.]+", "-", name).lower()]["version"] == version, name
    licences = {name: [one["license"].get("id") for one in rows[name]["licenses"] if "license" in one] for name in ("libceres-dev", "zlib1g")}
    assert "BSD-3-Clause" in licences["libceres-dev"] and licences["zlib1g"] == ["Zlib"]


@BUILT_HERE
def test_the_notices_name_all_that_is_asked_for_directly(bill):
    notices = (REPOSITORY / "THIRD_PARTY.md").read_text()
    whole = json.loads(bill)
    direct = next(one["dependsOn"] for one in whole["dependencies"] if one["ref"] == whole["metadata"]["component"]["bom-ref"])
    names = {re.match(r"pkg:\w+/(?:debian/)?([^@]+)@", ref).group(1) for ref in direct}
    assert len(names) > 30
    missing = [name for name in sorted(names) if not re.search(rf"\b{re.escape(name)}(?![\w-])", notices.replace("_", "-"))]
    assert not missing, f"THIRD_PARTY.md does not name {', '.join(missing)}"
