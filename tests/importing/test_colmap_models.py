"""Which of a COLMAP project's models is taken: a project that falls apart has several."""

import struct

import pytest
from made_sources import REPOSITORY

with_colmap = pytest.mark.skipif(not (REPOSITORY / ".venv-colmap/bin/python3").exists(), reason="COLMAP is not set up: tools/setup.sh colmap")

def write_model(folder, count: int, binary: bool = False) -> None:
    folder.mkdir(parents=True)
    if binary:
        (folder / "cameras.bin").write_bytes(b"")
        (folder / "images.bin").write_bytes(count.to_bytes(8, "little") + bytes(40))
    else:
        (folder / "cameras.txt").write_text("# Camera list\n1 PINHOLE 640 480 500 500 320 240\n")
        lines = [f"{i} 1 0 0 0 0 0 {i} 1 {i}.png\n{'1.5 2.5 7' if i % 2 else ''}\n" for i in range(1, count + 1)]
        (folder / "images.txt").write_text("# Image list with two lines of data per image\n" + "".join(lines))


# verifies: GND-03
@pytest.mark.parametrize("binary", [True, False])
def test_the_largest_is_taken_and_the_others_are_told(tmp_path, binary):
    from polhode_ground.importing.colmap_project import largest_model
    for name, count in (("0", 3), ("1", 40), ("2", 5)):
        write_model(tmp_path / "sparse" / name, count, binary)
    folder, said = largest_model(tmp_path)
    assert folder == tmp_path / "sparse/1"
    assert said.startswith("3 models, by their pictures: sparse/1 (40), sparse/2 (5), sparse/0 (3); the largest is taken")
    assert largest_model(tmp_path / "sparse/0") == (tmp_path / "sparse/0", "")  # one that the user names
    assert largest_model(tmp_path / "sparse")[0] == tmp_path / "sparse/1"


def test_of_two_that_are_equal_the_user_chooses(tmp_path):
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.colmap_project import largest_model
    write_model(tmp_path / "sparse/0", 4)
    write_model(tmp_path / "sparse/1", 4)
    other = tmp_path / "sparse/1/images.txt"
    other.write_text(other.read_text().replace(".png", ".jpg"))
    with pytest.raises(BadInput, match=r"2 models, by their pictures: sparse/0 \(4\), sparse/1 \(4\); the largest are equal: name the folder of one"):
        largest_model(tmp_path)


def test_a_copy_of_a_model_is_no_question(tmp_path):
    from polhode_ground.importing.colmap_project import largest_model
    write_model(tmp_path / "sparse/0", 4)
    write_model(tmp_path / "sparse/1", 4)
    assert largest_model(tmp_path)[0] == tmp_path / "sparse/0"


@pytest.mark.parametrize("place", ["sparse/0", "sparse", "dense/sparse", "dense/0/sparse", "colmap/sparse/0", "0", "."])
def test_models_are_found_where_tools_put_them(tmp_path, place):
    from polhode_ground.importing.colmap_project import model_folder
    assert model_folder(tmp_path) is None
    if place == ".":
        write_model(tmp_path / "sparse/0", 1)
        assert model_folder(tmp_path / "sparse/0") == tmp_path / "sparse/0"
    else:
        write_model(tmp_path / place, 1)
        assert model_folder(tmp_path) == tmp_path / place


@pytest.fixture
def project(tmp_path):
    """(folder of a binary model whose pictures have blanks in their names, its cameras, its images)."""
    cameras = struct.pack("<QIiQQ4d", 1, 1, 1, 640, 480, 500, 500, 320, 240)
    images = struct.pack("<Q", 3) + b"".join(struct.pack("<I7dI", i, 1, 0, 0, 0, 0, 0, i, 1) + b"my picture \xfc%d.png\0" % i + bytes(8) for i in (1, 2, 3))
    for name, octets in (("cameras", cameras), ("images", images), ("points3D", bytes(8))):
        (tmp_path / f"{name}.bin").write_bytes(octets)
    return tmp_path, cameras, images


NAMES = [f"my picture \udcfc{i}.png" for i in (1, 2, 3)]


@pytest.mark.further
@with_colmap
def test_names_with_blanks_and_of_any_encoding(project, tmp_path_factory):
    from polhode_ground.importing.colmap_library import read_project
    assert [image["name"] for image in read_project(project[0])["images"]] == NAMES
    text = tmp_path_factory.mktemp("text")
    (text / "cameras.txt").write_bytes(b"1 PINHOLE 640 480 500 500 320 240\r\n")
    (text / "images.txt").write_bytes(b"# a list\r\n" + b"".join(b"%d 1 0 0 0 0 0 0 1 my picture \xfc%d.png\r\n%s\r\n" % (i, i, b"1 2 -1" * (i % 2)) for i in (1, 2, 3)))
    (text / "points3D.txt").write_text("")
    assert [image["name"] for image in read_project(text)["images"]] == NAMES


@pytest.mark.further
@with_colmap
@pytest.mark.parametrize(("name", "octets", "says"), [("cameras", -12, "cameras.bin is cut: it has 52 octets, its cameras need 64"), ("cameras", 20, "cut"),
                                                      ("images", -8, "images.bin is cut or damaged"), ("images", 100, "cut or damaged"), ("images", 3, "cut or")])
def test_files_that_end_early_are_refused(project, name, octets, says):
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.colmap_library import read_project
    file = project[0] / f"{name}.bin"
    file.write_bytes(file.read_bytes()[:octets])
    with pytest.raises(BadInput, match=says):
        read_project(project[0])


def test_names_that_windows_wrote(tmp_path):
    from polhode_ground.importing.colmap_project import _with_slashes
    (tmp_path / "images/a").mkdir(parents=True)
    (tmp_path / "images/a/1.png").touch()
    images = [{"name": "a\\1.png", "camera": "1"}]
    _with_slashes(tmp_path, tmp_path / "sparse/0", images)
    assert images[0]["name"] == "a/1.png"
