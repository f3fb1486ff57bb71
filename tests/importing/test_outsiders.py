"""Pictures beside a numbered series are no frames of it: what they are is told by their names, and copies by what they show."""

import made_sources as sources
import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.outsiders import of_the_series
from polhode_ground.importing.pictures import natural_order
from polhode_ground.importing.source import Account

COUNT = 12
SERIES = [f"img_{i:04d}.png" for i in range(COUNT)]


def picture(index: int) -> np.ndarray:
    return np.arange(48 * 64, dtype=np.uint8).reshape(48, 64) // 2 + np.uint8(5 * index % 120)


@pytest.fixture
def folder(tmp_path):
    """A folder of the series and these: a name alone, or (name, what it shows)."""
    def make(*more):
        (tmp_path / "in").mkdir()
        for place, name in enumerate([*SERIES, *more]):
            name, index = name if isinstance(name, tuple) else (name, place)
            Image.fromarray(picture(index)).save(tmp_path / "in" / name)
        return tmp_path / "in"
    return make


def kept(folder, camera="cam0"):
    account = Account()
    files = sorted(folder.iterdir(), key=natural_order)
    return [file.name for file in of_the_series(files, camera, account)], account


# verifies: GND-03
@pytest.mark.parametrize("names", [["background.png"], ["dark.png", "flat_01.png"], [f"calib_{i:02d}.png" for i in range(5)], ["img_0003_thumb.png"],
                                   ["calib_2000.png"], ["99_dark.png", "bad.png"]])
def test_pictures_of_other_names_are_left_out_and_named(folder, names):
    found, account = kept(folder(*names))
    assert found == SERIES and account.dropped == {"of another series, by their names": len(names)}
    assert f"{len(names)} pictures are left out, as their names are not those of the series img_#" in account.assumed[0] and names[0] in account.assumed[0]


def test_they_are_taken_where_the_user_says_so(folder):
    calibration = [f"calib_{i:02d}.png" for i in range(5)]
    place = folder(*calibration, "dark.png")
    assert kept(place, "calib")[0] == calibration and kept(place, "dark")[0] == ["dark.png"]
    assert kept(place, "img")[0] == SERIES


def test_a_group_that_is_nearly_as_large_is_asked_for(folder):
    place = folder(*[f"calib_{i:02d}.png" for i in range(8)])
    with pytest.raises(BadInput, match=r"pictures of 2 series in one folder, by their names: calib_# \(8\), img_# \(12\); choose by a word of the names, as --camera calib"):
        kept(place)
    assert kept(place, "img")[0] == SERIES


# verifies: GND-03
@pytest.mark.parametrize("name", ["img_0003 (1).png", "img_0003 - Copy.png", "img_0003_copy2.bmp", "Copy of img_0003.png", "img_0003.bmp"])
def test_copies_are_left_out_and_told(folder, name):
    found, account = kept(folder((name, 3)))
    assert found == SERIES and account.dropped == {"copies of pictures that are there": 1}
    assert account.assumed == [f"1 pictures are left out as copies: {name} of img_0003.png"]


def test_a_copy_that_shows_something_else_is_no_copy(folder):
    found, account = kept(folder(("img_0003 (1).png", 20)))
    assert found == SERIES and account.dropped == {"of another series, by their names": 1} and "img_0003 (1).png" in account.assumed[0]


@pytest.mark.parametrize("names", [[f"IMG_{i}{'_edited' if i == 3 else ''}.png" for i in range(6)], [f"a_{i}.png" for i in range(6)] + [f"b_{i}.png" for i in range(6, 9)],
                                   [f"2026010{i}_125958.png" for i in range(1, 6)] + ["20260102_125958(0).png"], [f"{i}.png" for i in range(4)] + ["4.bmp", "5.jpg"],
                                   ["img.png", *(f"img ({i}).png" for i in range(1, 5))], [f"{i:04x}.png" for i in range(32)], ["sun.png", "cat.png", "1.png"]])
def test_what_belongs_to_a_series_stays(tmp_path, names):
    sources.write_pictures(tmp_path / "in", [picture(i) for i in range(len(names))], names)
    found, account = kept(tmp_path / "in")
    assert sorted(found) == sorted(names) and not account.dropped and not account.assumed


# verifies: GND-03
def test_the_sequence_has_the_frames_of_the_series_at_their_times(folder, imported):
    place = folder("background.png", ("img_0003 (1).png", 3))
    Image.fromarray(picture(0) > 60).save(place / "dark.png")
    (place / "img_0005.png").unlink()
    sequence, out = imported(place, "--rate-hz", 5, "--intrinsics", "80,80,31.5,23.5")
    assert [time // 200_000_000 for time in sequence.timestamp_ns.tolist()] == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11] and "one bit" not in out
    shown = [np.asarray(Image.open(sequence.folder / "mav0/cam0/data" / name)) for name in sequence.filenames]
    assert all(np.array_equal(pixels, picture(i)) for pixels, i in zip(shown, [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11]))


def test_a_remark_on_one_picture_is_not_said_of_all(tmp_path, imported):
    sources.write_pictures(tmp_path / "in", [picture(i) for i in range(6)], [f"{i}.png" for i in range(6)])
    Image.fromarray(picture(2) > 60).save(tmp_path / "in/2.png")
    _, out = imported(tmp_path / "in", "--intrinsics", "80,80,31.5,23.5")
    assert "one bit: black and white alone (of 1 of 6 pictures)" in out
