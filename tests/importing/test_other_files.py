"""What people name that is no sequence by itself, and what stands beside one: times of laboratories, archives, folders of videos."""

import made_sources as sources
import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.plan import Part, Plan
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Options

NS = 1_000_000_000
PICTURES = [np.full((8, 8), 20 * i, np.uint8) for i in range(6)]


# verifies: GND-03
@pytest.mark.parametrize(("place", "row", "says"), [
    ("../times.txt", "{s:e}", ""), ("times.txt", "{i:05d} {s:.6f} 12.5", ""), ("timestamps.csv", "{us}", "microseconds"), ("../timestamps.txt", "{ns}", "nanoseconds")])
def test_times_beside_the_pictures(tmp_path, place, row, says):
    sources.write_pictures(tmp_path / "seq/images", PICTURES, [f"{i:06d}.png" for i in range(6)])
    lines = [row.format(i=i, s=i / 8, us=i * 125_000, ns=1_403_636_579 * NS + i * NS // 8) for i in range(6)]
    (tmp_path / "seq/images" / place).write_text("\n".join(lines) + "\n")
    source = open_source(tmp_path / "seq/images", Options())
    said = " ".join(source.account.assumed)
    assert set(np.diff(source.times_ns)) == {NS // 8} and not source.nominal_time and "one a picture in the order of their names" in said and says in said


@pytest.mark.parametrize(("content", "says"), [("1\n2\n", "it has 2 times for 6 pictures"), ("see the notebook\n", "it lists no times"),
    ("0,000\n0,040\n0,080\n0,120\n0,160\n0,200\n", "looks like a number with a decimal comma"), ("time\n1\n2\n\"\"\n4\n5\n6\n", "is not a time")])
def test_times_that_do_not_fit_are_told(tmp_path, content, says):
    sources.write_pictures(tmp_path / "seq", PICTURES, [f"{i:06d}.png" for i in range(6)])
    (tmp_path / "seq/times.txt").write_text(content)
    source = open_source(tmp_path / "seq", Options())
    assert source.nominal_time and says in " ".join(source.account.assumed)


@pytest.mark.parametrize(("time", "first_ns"), [
    ("{s:.3f}", 0), ("1970-01-01T00:00:{s:06.3f}Z", 0), ("2026-03-29 00:59:{s:06.3f}", 1_774_745_940 * NS), ("2026-03-29T02:59:{s:06.3f}+02:00", 1_774_745_940 * NS)])
def test_a_list_beside_pictures_holds_by_the_names_in_it(tmp_path, time, first_ns):
    order = [3, 0, 5, 1, 4, 2]
    sources.write_pictures(tmp_path / "seq", PICTURES, [f"x{number}.png" for number in order])
    rows = [f"x{number}.png,{time.format(s=place / 8)}" for place, number in enumerate(order)]
    (tmp_path / "seq/times.csv").write_text("\n".join(["name,time", *rows]) + "\n")
    source = open_source(tmp_path / "seq", Options())
    assert "by the names in it" in " ".join(source.account.assumed)
    by_time = sorted((frame.timestamp_ns, int(np.asarray(Image.open(frame.file)).max())) for frame in source.frames)
    assert by_time == [(first_ns + place * NS // 8, 20 * place) for place in range(6)]


# verifies: GND-03
@pytest.mark.parametrize(("head", "row", "says"), [
    ("frame_id,filename,timestamp_us,exposure_us", "{i},{name},{us},{us}7", "times are those of"), ("image;exposure;t [ms]", "{name};7;{ms}", "times are those of"),
    ("filename,timestamp_us,time_received", "{name},{us},{us}", "timestamp_us and time_received may both be the times"),
    ("filename,timestamp_us", "other{name},{us}", "it does not list 6 of the 6 pictures, as x0.png"), ("roll,pitch", "{i},{i}", "")])
def test_a_table_of_any_name_is_read_by_its_head(tmp_path, head, row, says):
    sources.write_pictures(tmp_path / "seq", PICTURES, [f"x{i}.png" for i in range(6)])
    rows = [row.format(i=i, name=f"x{5 - i}.png", us=1_700_000_000_000_000 + i * 125_000, ms=i * 125) for i in range(6)]
    (tmp_path / "seq/frames.csv").write_text("\n".join([head, *rows]) + "\n")
    source = open_source(tmp_path / "seq", Options())
    said = " ".join(source.account.assumed[1:])
    assert says in said and ("frames.csv" in said) == bool(says) and source.nominal_time == ("times are those of" not in said)
    if not source.nominal_time:
        assert set(np.diff(source.times_ns)) == {-NS // 8}


def test_options_that_nothing_asks_for_are_told(tmp_path):
    sources.write_pictures(tmp_path / "seq", PICTURES, [f"{i:06d}.png" for i in range(6)])
    source = open_source(tmp_path / "seq", Options(stamp_unit="us"))
    Plan(source, Part(unwrap=True))
    said = " ".join(source.account.assumed)
    assert "--stamp-unit is left out" in said and "--unwrap is left out" in said


def test_formats_of_which_one_is_not_whole_are_asked_for(tmp_path):
    names = [f"DSC_{i}.png" for i in range(6)]
    sources.write_pictures(tmp_path / "seq", PICTURES + PICTURES[:3], [*names, "DSC_0.tif", "DSC_1.tif", "DSC_2.tif"])
    with pytest.raises(BadInput, match=r"DSC_#.png \(6\), DSC_#.tif \(3\)"):
        open_source(tmp_path / "seq", Options())


@pytest.mark.parametrize(("content", "says"), [
    (b"PK\x03\x04..", "a ZIP archive: unpack it first"), (b"\0" * 257 + b"ustar", "a tar archive"), (b"\x93NUMPY", "a NumPy array: write its pictures into a folder"),
    (b"#ROSBAG V2.0\n", "a bag of ROS 1: give it a name that ends in .bag")])
def test_other_files_are_named(tmp_path, content, says):
    (tmp_path / "recording").write_bytes(content)
    with pytest.raises(BadInput, match=f"found {says}.*; expected a video"):
        open_source(tmp_path / "recording", Options())


def test_what_to_name_in_a_folder(tmp_path):
    (tmp_path / "GX010001.MP4").write_bytes(b"?")
    with pytest.raises(BadInput, match="it holds videos: name one of them, as GX010001.MP4"):
        open_source(tmp_path, Options())
    sources.write_pictures(tmp_path / "more/cam0", PICTURES, [f"{i}.png" for i in range(6)])
    with pytest.raises(BadInput, match="pictures are in folders below: name one of them, as cam0"):
        open_source(tmp_path / "more", Options())


def test_a_bag_that_was_split_is_one(tmp_path):
    store = sources.ros_types(1)
    for part in range(2):
        messages = [("/cam", (3 * part + i + 1) * NS, sources.image_message(store, PICTURES[3 * part + i], (3 * part + i + 1) * NS)) for i in range(3)]
        sources.write_bag(tmp_path / f"rec_{part}.bag", 1, messages)
    source = open_source(tmp_path, Options())
    assert [int(frame.pixels[0, 0]) for frame in source.frames] == [0, 20, 40, 60, 80, 100] and "parts of one recording" in source.account.assumed[0]


def ser(path, ticks=()):
    head = b"LUCAM-RECORDER" + np.array([0, 0, 1, 8, 8, 8, 6], "<i4").tobytes() + bytes(136)
    path.write_bytes(head + b"".join(pixels.tobytes() for pixels in PICTURES) + np.array(ticks, "<i8").tobytes())
    return path


def test_the_times_of_ser(tmp_path):
    source = open_source(ser(tmp_path / "a.ser", [638_000_000_000_000_000 + i * 1_250_000 for i in range(6)]), Options())
    assert set(np.diff(source.times_ns)) == {NS // 8} and [frame.timestamp_ns for frame in source.frames] == source.times_ns
    source = open_source(ser(tmp_path / "b.ser"), Options())
    assert set(np.diff(source.times_ns)) == {NS} and source.nominal_time and "tells no times" in " ".join(source.account.assumed)
    assert set(np.diff(open_source(ser(tmp_path / "b.ser"), Options(rate_hz=4.0)).times_ns)) == {NS // 4}


def test_two_pictures_in_one_are_told(imported, tmp_path):
    sources.write_pictures(tmp_path / "pairs", [np.full((40, 160), 20 * i, np.uint8) for i in range(4)], [f"{i}.png" for i in range(4)])
    _, out = imported(tmp_path / "pairs", "--intrinsics", "60,60,79.5,19.5")
    assert "pictures of 160x40: if they show two cameras in one" in out


def test_several_jpegs_in_one_file_are_no_single_picture(tmp_path, refused):
    pages = [Image.fromarray(np.full((48, 64), 20 * i, np.uint8)) for i in range(5)]
    pages[0].save(tmp_path / "five.mpo", save_all=True, append_images=pages[1:])
    pages[0].save(tmp_path / "one.jpg")
    assert "found 5 JPEGs in one file (MPO): write those of one camera into a folder" in refused(tmp_path / "five.mpo", "--intrinsics", "60,60,31.5,23.5")
    assert "found a single picture" in refused(tmp_path / "one.jpg", "--intrinsics", "60,60,31.5,23.5")


def test_an_end_before_the_begin_is_told_as_such(tmp_path, refused):
    assert "--from 2 --to 1: --to is before --from" in refused(tmp_path, "--from", 2, "--to", 1)


# verifies: GND-03
def test_thumbnails_of_videos_are_no_sequence(tmp_path):
    sources.write_pictures(tmp_path / "card", PICTURES[:3], ["GX010042.jpg", "GX020042.jpg", "GX030042.jpg"])
    for path, name in zip(sorted((tmp_path / "card").iterdir()), ("GX010042.THM", "GX020042.jpg", "GX990042.thm")):
        path.rename(path.with_name(name))
    for name in ("GX010042.MP4", "GX020042.MP4"):
        (tmp_path / "card" / name).write_bytes(b"video")
    with pytest.raises(BadInput, match="it holds videos: name one of them, as GX010042.MP4"):
        open_source(tmp_path / "card", Options())
    large = np.zeros((480, 640), np.uint8)  # of a phone that takes a video with each photograph
    for i in range(3):
        Image.fromarray(large).save(tmp_path / f"card/IMG_{i}.jpg")
        (tmp_path / f"card/IMG_{i}.MOV").write_bytes(b"video")
    source = open_source(tmp_path / "card", Options())
    assert len(source.times_ns) == 3 and "3 pictures are left out: thumbnails of videos" in source.account.assumed
