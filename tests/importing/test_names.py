"""Names of pictures, as cameras, phones and Windows give them: their order, their times, what is missing, and whether they are of one camera."""

import datetime
import pathlib

import made_sources as sources
import numpy as np
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.folder import times_of
from polhode_ground.importing.numbering import frame_numbers, in_order
from polhode_ground.importing.pictures import natural_order
from polhode_ground.importing.series import of_one_camera
from polhode_ground.importing.source import Account

US_STEP_UNKNOWN = 10**9  # a picture a second
US = 1_403_636_579_763_555  # in 2014
STEPS = [US + 50_000 * i for i in range(8)]


def files(names) -> list[pathlib.Path]:
    return sorted(map(pathlib.Path, names), key=natural_order)


def numbered(names) -> tuple[list[str], list[int], str]:
    """(names in order, their frames, what is said)."""
    ordered, said = in_order(files(names))
    found = [path.name for path in ordered]
    frames, more = frame_numbers(found)
    return found, frames, " ".join([*said, more])


# verifies: GND-03
@pytest.mark.parametrize(("names", "frames", "says"), [
    ([f"frame_{i:04x}.png" for i in range(8, 40) if i != 27], [*range(19), *range(20, 32)], "hexadecimal the numbers in the pictures' names jump"),
    ([f"{i:X}.png" for i in range(250, 260 - 4)], range(6), ""),
    (["img.png", *(f"img ({i}).png" for i in range(1, 12))], range(12), ""),
    ([f"img ({i}).png" for i in (1, 2, 3, 5)], [0, 1, 2, 4], "1 pictures are missing"),
    ([f"DSC_{i % 10000:04d}.jpg" for i in range(9990, 10008)], range(18), "DSC_9999.jpg is followed by DSC_0000.jpg"),
    ([f"IMG_{i:04d}.jpg" for i in (9997, 9998, 9999, 1, 2, 4)], [0, 1, 2, 3, 4, 6], "IMG_9999.jpg is followed by IMG_0001.jpg"),
    ([f"f_{i:04d}_{5 + 5 * (i % 2)}ms.png" for i in (0, 1, 2, 3, 5, 6)], [0, 1, 2, 3, 5, 6], "1 pictures are missing"),
    ([f"IMG_20260101_125958_{i:03d}.jpg" for i in (1, 2, 3, 5)], [0, 1, 2, 4], "1 pictures are missing"),
    ([f"a{i}_{7 * i * i % 19}.png" for i in (1, 4, 5, 9, 23)], range(5), "no count of frames"),
    (["a1.png", "b1.png", "c1.png"], range(3), "no count of frames"),
    ([f"f_{(2**32 + i * 40000) % 2**32:010d}.png" for i in (-3, -2, 0, 1, 2, 4)], [0, 1, 3, 4, 5, 7], "f_4294887296.png is followed by f_0000000000.png"),
    ([f"f_{(2**16 + 17 + i * 40) % 2**16}.png" for i in range(-4, 6)], range(10), "f_65513.png is followed by f_17.png"),
    ([f"f_{i}.png" for i in (0, 1, 2, 65000)], [0, 1, 2, 65000], "64997 pictures are missing"),
    ([f"{i:04d}.png" for i in (0, 1, 2, 9996)], [0, 1, 2, 9996], "9993 pictures are missing")])
def test_numbers_of_every_kind(names, frames, says):
    found, numbers, said = numbered(names)
    assert found == names and numbers == list(frames) and says in said and bool(says) == bool(said.strip())


def test_hashes_are_no_numbers():
    names = [f"{i * 2654435761 % 2**32:08x}.png" for i in range(9)]
    assert "hexadecimal" not in numbered(names)[2]


@pytest.mark.parametrize(("name", "step_ns"), [
    ("{us}.png", 50_000_000), ("cam0_{us}000.png", 50_000_000), ("{ms}.png", 50_000_000), ("{s}_{part:06d}.png", 50_000_000), ("{s}.{part:06d}.png", 50_000_000),
    ("frame-{s}-{part:06d}000.png", 50_000_000), ("PXL_20260101_1259{i:02d}250.jpg", 10**9), ("2026-01-01 12.59.{i:02d}.jpg", 10**9)])
def test_times_in_names(name, step_ns):
    names = [name.format(us=us, ms=us // 1000, s=us // 10**6, part=us % 10**6, i=i) for i, us in enumerate(STEPS)]
    times, nominal, said = times_of(files(names), None)
    assert not nominal and set(np.diff(times)) == {step_ns} and "in the pictures' names" in said[0]
    assert times[0] // 10**12 == (1403636 if step_ns != 10**9 else 1767272)


# verifies: GND-03
@pytest.mark.parametrize("name", ["{}.png", "left-{}.png", "{}_cam2.png"])
def test_decimal_seconds_are_one_number(name):
    ticks = [100 * (US // 10**6) + place for place in (80, 85, 90, 95, 100, 105, 200)]  # 1.8 s to 3 s, in 0.01 s
    ordered, said = in_order(files(name.format(f"{tick // 100}.{tick % 100:02d}".rstrip("0").rstrip(".")) for tick in ticks))
    times, nominal, why = times_of(ordered, None)
    assert times == [tick * 10**7 for tick in ticks] and not nominal and not said and "in the pictures' names" in why[0]


def test_decimals_that_are_no_seconds_are_an_order():
    small = in_order(files(f"{0.05 * i:.4g}.png" for i in range(1, 31)))[0]
    assert [float(path.stem) for path in small] == [float(f"{0.05 * i:.4g}") for i in range(1, 31)]
    assert frame_numbers([path.name for path in small if path.stem != "0.2"])[0] == [*range(3), *range(4, 30)]
    versions = [f"1.{i}.png" for i in range(1, 12)]
    assert [path.name for path in in_order(files(versions))[0]] == versions
    unpadded = files(f"1700000000.{i * 50_000_000}.png" for i in range(1, 12))  # 0.05 s is no 0.5 s
    assert times_of(unpadded, None)[1]


# verifies: GND-03
@pytest.mark.parametrize(("name", "part"), [("cam1_{:%Y%m%d_%H%M%S}_{}.png", 10**6), ("{:%Y-%m-%d-%H-%M-%S}-{}.png", 10**3), ("IMG_{:%Y%m%dT%H%M%S}.{}.jpg", 1)])
def test_parts_of_a_second_may_stand_behind_the_clock(name, part):
    begin = datetime.datetime(2024, 5, 1, 23, 59, 58, tzinfo=datetime.UTC)
    steps_ns = [500_000_000 + i * 250_000_000 + (2_000_000_000 if i > 9 else 0) for i in range(16)]
    width = len(str(10**9 // part)) - 1
    names = [name.format(begin + datetime.timedelta(seconds=ns // 10**9), f"{ns % 10**9 // part:0{width}d}") for ns in steps_ns]
    times, nominal, said = times_of(files(names), None)
    assert not nominal and [time - int(begin.timestamp()) * 10**9 for time in times] == steps_ns and "dates and clocks" in said[0]


@pytest.mark.parametrize("name", ["{i:016d}.png", "20260101{i:05d}.png", "{i:013d}_x.png", "IMG_20261399_1259{i:02d}.jpg"])
def test_numbers_that_are_no_times(name):
    names = [name.format(i=i) for i in range(8)]
    times, _, said = times_of(files(names), 10.0)
    assert times == [i * 10**8 for i in range(8)] and "--rate-hz" in said[0]


# verifies: GND-03
@pytest.mark.parametrize(("pair", "word"), [
    (("left_{i:03d}.png", "right_{i:03d}.png"), "left"), (("f_{i:03d}_R.png", "f_{i:03d}_L.png"), "r"), (("cam3_{i:03d}.png", "cam2_{i:03d}.png"), "cam3"),
    (("{i}_camera-1.png", "{i}_camera-2.png"), "camera1"), (("rgb_{i}.png", "depth_{i}.png"), "rgb"), (("{i}.jpg", "{i}.heic"), "jpg")])
def test_two_cameras_in_one_folder(pair, word):
    both = files(name.format(i=i) for i in range(6) for name in pair)
    with pytest.raises(BadInput, match=r"pictures of 2 cameras or formats in one folder, by their names: .* \(6\); choose by a word"):
        of_one_camera(both, "cam0", Account())
    account = Account()
    assert of_one_camera(both, word, account) == files(pair[0].format(i=i) for i in range(6)) and account.dropped == {"taken by another camera": 6}


# verifies: GND-03
def test_pictures_without_a_word_of_their_own_are_chosen_by_what_they_have_not():
    names = [f"{i:05d}{word}.png" for i in range(6) for word in ("", "_mask", "_depth")]
    for camera in ("cam0", "png", "no-rgb"):
        with pytest.raises(BadInput, match="choose by a word of the names, as --camera no-depth-mask for those without"):
            of_one_camera(files(names), camera, Account())
    account = Account()
    assert [file.stem for file in of_one_camera(files(names), "no-depth-mask", account)] == [f"{i:05d}" for i in range(6)]
    assert account.dropped == {"taken by another camera": 12} and "those without depth and mask in their names are taken" in account.assumed[0]


@pytest.mark.parametrize("names", [
    [f"{part}_{i}.png" for part in ("a", "b") for i in (range(3) if part == "a" else range(3, 6))], [f"p{part}_{i}.png" for part in (1, 2) for i in range(5)],
    ["x.png", "y.png", "z.png"], [f"left_{i}.png" for i in range(5)], [f"IMG_{i}{'_edited' if i == 3 else ''}.jpg" for i in range(6)]])
def test_one_camera_stays_one(names):
    account = Account()
    assert of_one_camera(files(names), "cam0", account) == files(names) and not account.dropped and not account.assumed


# verifies: GND-03
def test_a_counter_of_time_in_names_is_counted_on_and_has_the_unit_that_is_said(tmp_path, imported):
    places = [i for i in range(-6, 9) if i != 3]
    rows = np.add.outer(np.arange(48), np.arange(64))
    names = [f"frame_{(2**32 + 40_000 * i) % 2**32:010d}.png" for i in places]
    sources.write_pictures(tmp_path / "in", [np.uint8((rows + 7 * i) % 251) for i in range(len(names))], names)
    for arguments, step_ns in (([], US_STEP_UNKNOWN), (["--stamp-unit", "us"], 40_000_000)):
        sequence, out = imported(tmp_path / "in", "--intrinsics", "80,80,31.5,23.5", "--unwrap", *arguments, name=f"SEQ{step_ns}")
        assert [time // step_ns for time in (sequence.timestamp_ns - sequence.timestamp_ns[0]).tolist()] == [place + 6 for place in places]
        assert [int(sequence.read_gray(i)[0, 0]) for i in range(len(names))] == [7 * i for i in range(len(names))]
        assert "frame_4294927296.png is followed by frame_0000000000.png" in out and "--unwrap is left out" not in out
    assert "times are the numbers in the pictures' names, microseconds, as --stamp-unit says" in out
