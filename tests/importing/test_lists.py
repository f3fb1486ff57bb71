"""Lists of pictures as people have them: separators, marks, more columns, and stamps in another unit than such lists have."""

import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.picture_list import in_ns
from polhode_ground.importing.plan import Part, Plan
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Account, Options
from polhode_ground.importing.stamps import judge

NS = 1_000_000_000
STEP = 50_000_000
TIMES = [1_403_636_579_763_555_584 + i * STEP for i in range(8)]
SECONDS = [f"{time // NS}.{time % NS:09d}" for time in TIMES]


def euroc(folder, head, rows, coding="utf-8", names=None):
    data = folder / "mav0/cam0/data"
    data.mkdir(parents=True)
    for time, name in zip(TIMES, names or [f"{time}.png" for time in TIMES]):
        Image.fromarray(np.zeros((32, 32), np.uint8)).save(data / name)
    (folder / "mav0/cam0/data.csv").write_bytes("\n".join([*([head] if head else []), *rows, ""]).encode(coding))
    return folder


def taken(folder, **options):
    source = open_source(folder, Options(**options))
    return [frame.timestamp_ns for frame in Plan(source, Part()).frames()], " ".join(source.account.assumed)


# verifies: GND-03
@pytest.mark.parametrize(("head", "row", "coding"), [
    ("#timestamp [ns];filename", "{t};{t}.png", "utf-8"), ("timestamp,filename", "{t},{t}.png", "utf-8-sig"), (None, "{t}\t{t}.png", "utf-8"),
    ("#timestamp [ns],filename", "{t},{t}.png", "utf-16"), ("#timestamp [ns],filename", "{t},{t}.png", "utf-16-le"), ("#filename,timestamp", "{t}.png,{t}", "utf-8"),
    ("id,timestamp,filename", "{i},{t},{t}.png", "utf-8"), (None, "{i},{t},{t}.png", "utf-8"), ("#timestamp,filename,exposure", "{t},{t}.png,7", "utf-8"),
    ("exposure_time,timestamp [ns],file", "7,{t},{t}.png", "utf-8"), ("timestamp (s);file", "{c};{t}.png", "utf-8"), ("time_us,file", "{us},{t}.png", "utf-8"),
    ("#timestamp [ns],filename", "{t},mav0\\cam0\\data\\{t}.png", "utf-8"), ("#timestamp [ns],filename", "{t},/data/run/{t}.png", "utf-8"),
    ("#timestamp [ns],filename", "{t},{t}.png # bright", "utf-8"), (None, "{t}", "utf-8")])
def test_every_form_of_a_list(tmp_path, head, row, coding):
    rows = [row.format(i=i, t=time, c=second.replace(".", ","), us=time // 1000) for i, (time, second) in enumerate(zip(TIMES, SECONDS))]
    times, said = taken(euroc(tmp_path / "seq", head, rows, coding))
    assert times == [time // 1000 * 1000 if "{us}" in row else time for time in TIMES] and not said


# verifies: GND-03
@pytest.mark.parametrize(("head", "value", "begin_s", "says"), [
    ("#timestamp [100ns]", lambda ns: ns // 100 + 116_444_736_000_000_000, 1_700_000_000, "the times count 100ns since the year 1601: they are taken since 1970"),
    ("time_100ns", lambda ns: ns // 100 + 621_355_968_000_000_000, 1_700_000_000, "since the year 1:"), ("timestamp (100 ns)", lambda ns: ns // 100, 5, ""),
    ("timestamp [10 us]", lambda ns: ns // 10_000, 1_700_000_000, ""), ("t [nanoseconds]", lambda ns: ns, 0, ""), ("timestamp_1_us", lambda ns: ns // 1000, 0, ""),
    ("timestamp (camera)", lambda ns: ns, 1_700_000_000, ""), ("timestamp [UTC]", lambda ns: ns, 1_700_000_000, ""), ("time [s since start]", lambda ns: ns / NS, 0, "")])
def test_units_of_heads_and_counts_of_them(tmp_path, head, value, begin_s, says):
    rows = [f"{value(begin_s * NS + i * STEP)},{time}.png" for i, time in enumerate(TIMES)]
    times, said = taken(euroc(tmp_path / "seq", f"{head},filename", rows))
    assert times == [begin_s * NS + i * STEP for i in range(8)] and says in said and bool(says) == bool(said)


# verifies: GND-03
@pytest.mark.parametrize("unit", ["[ticks]", "(cycles)", "[1/90000 s]", "[fortnights]", "_ticks"])
def test_a_unit_that_is_not_known_is_refused_by_name(tmp_path, unit):
    folder = euroc(tmp_path / "seq", f"#timestamp{unit},filename", [f"{i * 50_000},{time}.png" for i, time in enumerate(TIMES)])
    with pytest.raises(BadInput, match=rf"in '{unit.strip('[()]_')}', allowed are \[s\], \[ms\], \[us\], \[ns\] and counts of them, as \[100ns\]; --stamp-unit"):
        taken(folder)
    assert taken(folder, stamp_unit="us")[0] == [i * STEP for i in range(8)]


def tum(folder, row, name="rgb/{i}.png", values=SECONDS):
    (folder / "rgb").mkdir(parents=True)
    for i in range(len(TIMES)):
        Image.fromarray(np.zeros((4, 4), np.uint8)).save(folder / name.format(i=i))
    (folder / "rgb.txt").write_text("# color images\n# timestamp filename\n" + "".join(f"{row.format(i=i, s=value)}\n" for i, value in enumerate(values)))
    return folder


@pytest.mark.parametrize(("row", "name"), [
    ("{s} rgb/{i}.png", "rgb/{i}.png"), ("{s} rgb/{i}.png 17.5 depth/{i}.png", "rgb/{i}.png"), ("17.5 depth/{i}.png {s} rgb/{i}.png", "rgb/{i}.png"),
    ("{s},rgb/{i}.png", "rgb/{i}.png"), ("{s} rgb/my cam {i}.png", "rgb/my cam {i}.png")])
def test_lists_of_tum_and_associated_ones(tmp_path, row, name):
    times, said = taken(tum(tmp_path / "tum", row, name))
    assert times == TIMES and not said


# verifies: GND-03
@pytest.mark.parametrize(("stated", "scale", "says"), [("ns", NS, "seconds"), ("ns", 10**6, "milliseconds"), ("ns", 10**3, "microseconds"), ("s", 1, "nanoseconds"),
                                                       ("s", 10**6, "milliseconds")])
@pytest.mark.parametrize("begin", [0, TIMES[0] // 10**6 * 10**6])
def test_stamps_of_another_unit_are_converted_and_told(stated, scale, says, begin):
    account = Account()
    values = [(begin + i * STEP) / scale if scale == NS else (begin + i * STEP) // scale for i in range(8)]
    if stated == "s" and scale == 10**6 and not begin:  # 50 s from picture to picture may be
        assert in_ns(values, stated, None, "list", account) == [50 * i * NS for i in range(8)] and "50 s from frame to frame" in account.assumed[0]
        return
    found = in_ns(values, stated, None, "list", account)
    assert np.allclose(np.diff(found), STEP, atol=300) and f"they are taken for {says}" in account.assumed[0]


def test_what_is_not_clear_is_refused_and_can_be_said():
    for step, likely in ((1000, "milliseconds or microseconds"), (1, "seconds or milliseconds")):
        with pytest.raises(BadInput, match=f"these look like {likely}; --stamp-unit s, ms, us or ns says which"):
            in_ns([step * i for i in range(8)], "ns", None, "list", Account())
    assert in_ns([0, 1000, 2000], "ns", "us", "list", Account()) == [0, 10**6, 2 * 10**6]
    with pytest.raises(BadInput, match="beyond what a sequence can hold"):
        in_ns([10**17, 2 * 10**17, 3 * 10**17], "ns", "s", "list", Account())


@pytest.mark.parametrize("step_ns", [1_000_000, 33_333_333, NS, 20 * NS])
def test_stamps_of_cameras_are_not_doubted(step_ns):
    for begin in (0, 1_400_000_000, TIMES[0]):
        account = Account()
        values = [begin + i * step_ns for i in range(8)]
        assert in_ns(values, "ns", None, "list", account) == values and not account.assumed


def test_a_decimal_comma_between_commas_is_refused(tmp_path):
    rows = [f"{second.replace('.', ',')},{time}.png" for time, second in zip(TIMES, SECONDS)]
    with pytest.raises(BadInput, match="data.csv:2: 3 cells where the head has 2, as with a decimal comma"):
        taken(euroc(tmp_path / "seq", "#timestamp,filename", rows))


def test_names_in_another_unit_without_a_list(tmp_path):
    folder = euroc(tmp_path / "seq", None, [], names=[f"{time // 1000}.png" for time in TIMES])
    (folder / "mav0/cam0/data.csv").unlink()
    (folder / "mav0/cam0/sensor.yaml").write_text("")
    times, said = taken(folder)
    assert set(np.diff(times)) == {STEP} and "they are taken for microseconds" in said


@pytest.mark.parametrize("begin", [0, TIMES[0]])
def test_header_stamps_in_microseconds_are_seen_by_the_receipts(begin):
    stamps, received = [begin + i * 50_000 for i in range(20)], [TIMES[0] + i * STEP + i % 3 * 1_000_000 for i in range(20)]
    judgement = judge(stamps, received)
    assert judgement.times_ns == [begin + i * STEP for i in range(20)] and "a unit of 1000 ns" in judgement.assumed[0]
    assert judge([begin + i * STEP for i in range(20)], [i * NS * 50 for i in range(20)]).assumed == []  # a simulation that is slow


# verifies: GND-03
def test_the_truth_of_a_source_comes_along_and_others_are_told(run, tmp_path):
    folder = euroc(tmp_path / "seq", "#timestamp [ns],filename", [f"{time},{time}.png" for time in TIMES])
    (folder / "truth.csv").write_text("timestamp_ns\n")
    (folder / "mav0/state_groundtruth_estimate0").mkdir()
    (folder / "mav0/state_groundtruth_estimate0/data.csv").write_text("#timestamp\n")
    done = run(folder, tmp_path / "SEQ", "--intrinsics", "40,40,15.5,15.5")
    assert done.returncode == 0 and (tmp_path / "SEQ/truth.csv").read_text() == "timestamp_ns\n"
    assert "truth.csv of the source is copied" in done.stdout and "state_groundtruth_estimate0 is left out: it is the path of the camera's carrier" in done.stdout
    assert "7 of 8 pictures repeat the one before" in done.stdout  # all are alike


def test_pictures_that_repeat_are_told():
    from polhode_ground.importing.repeats import Repeats
    rng = np.random.default_rng(2)
    film = [rng.integers(0, 255, (48, 64), np.uint8) for _ in range(25)]
    for pictures, says in ((film, ""), ([film[i * 4 // 5] for i in range(25)], "5 of 25 pictures repeat the one before, one of 5 as if made of a lower rate, first picture 2"),
                           ([film[0] // 2 + film[i] // 8 for i in range(25)], ""), (film[:20] + [film[19]] * 5, "5 of 25 pictures repeat the one before, first picture 21")):
        repeats, account = Repeats(), Account()
        for pixels in pictures:
            repeats.add(pixels)
        repeats.tell(account)
        assert bool(account.assumed) == bool(says) and says in " ".join(account.assumed)


def test_a_bag_that_is_still_open_is_named(tmp_path):
    (tmp_path / "rec.bag.active").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(BadInput, match="a recording that its recorder did not close; .* `rosbag reindex`"):
        open_source(tmp_path / "rec.bag.active", Options())


# verifies: GND-03
@pytest.mark.parametrize("stamp", ["nan", "-inf", "---", "00:00:59;20", "17000.5.3", "?"])
def test_a_first_row_without_a_time_is_no_head(tmp_path, stamp):
    with pytest.raises(BadInput, match="rgb.txt:3: '.* rgb/0.png' is not 'seconds file'"):
        taken(tum(tmp_path / "tum", "{s} rgb/{i}.png", values=[stamp, *SECONDS[1:]]))
    with pytest.raises(BadInput, match="data.csv:1: '.*png' is not a time"):
        taken(euroc(tmp_path / "seq", None, [f"{stamp.replace(';', ':')},{TIMES[0]}.png", *[f"{time},{time}.png" for time in TIMES[1:]]]))


def kitti(folder, lines):
    (folder / "data").mkdir(parents=True)
    for i in range(len(TIMES)):
        Image.fromarray(np.full((4, 4), i, np.uint8)).save(folder / f"data/{i:010d}.png")
    (folder / "timestamps.txt").write_text("".join(f"{line}\n" for line in lines))
    return folder / "data"


# verifies: GND-03
def test_dates_and_clocks_beside_pictures_are_their_times(tmp_path):
    lines = [f"2011-09-26 13:02:5{i}.{100_000_001 + 1000 * i}" for i in range(8)]
    times, said = taken(kitti(tmp_path / "raw", lines))
    assert times == [1_317_042_170_100_000_001 + i * (NS + 1000) for i in range(8)] and "times are those of" in said
    times, said = taken(kitti(tmp_path / "bad", ["nan", *lines[1:]]))
    assert times == [i * NS for i in range(8)] and "timestamps.txt is left out: 1: 'nan' is not a time" in said


# verifies: GND-03
@pytest.mark.parametrize("made", [lambda path, rows: euroc(path, "#timestamp [ns],filename", rows), lambda path, rows: euroc(path, None, rows)])
def test_numbers_of_frames_become_times_by_the_rate(tmp_path, made):
    rows = [f"{i + (i > 3)},{time}.png" for i, time in enumerate(TIMES)]
    with pytest.raises(BadInput, match="--stamp-unit s, ms, us or ns says which; if they are numbers of frames, --rate-hz says how many there are a second"):
        taken(made(tmp_path / "seq", rows))
    times, said = taken(tmp_path / "seq", rate_hz=25.0)
    assert times == [i * NS // 25 for i in (0, 1, 2, 3, 5, 6, 7, 8)] and "numbers of frames in place of times: 0.04 s from one to the next" in said


def test_whole_seconds_that_the_user_asks_for_are_doubted(tmp_path):
    rows = [f"{i},{time}.png" for i, time in enumerate(TIMES)]
    times, said = taken(euroc(tmp_path / "seq", None, rows), stamp_unit="s", rate_hz=25.0)
    assert times == [i * NS for i in range(8)]
    assert said == ("--rate-hz is left out: the list tells its times the times are whole seconds, one after the other; "
                    "if they are numbers of frames, --rate-hz without --stamp-unit says how many there are a second")


def test_a_rate_beside_times_is_told_to_have_no_effect(tmp_path):
    times, said = taken(tum(tmp_path / "tum", "{s} rgb/{i}.png"), rate_hz=25.0)
    assert times == TIMES and said == "--rate-hz is left out: the list tells its times"
    seconds = euroc(tmp_path / "seq", None, [f"{1_700_000_000 + i},{time}.png" for i, time in enumerate(TIMES)])
    times, _ = taken(seconds, rate_hz=25.0)
    assert set(np.diff(times)) == {NS}


def test_a_unit_in_a_head_of_blanks_is_found(tmp_path):
    folder = tum(tmp_path / "tum", "{s} rgb/{i}.png", values=[i * 500_000 for i in range(8)])
    for head, says in (("# timestamp [100 ns] filename", ""), ("# timestamp [ticks] filename", "in 'ticks', allowed are")):
        lines = (folder / "rgb.txt").read_text().splitlines()[2:]
        (folder / "rgb.txt").write_text("\n".join(["# color images", head, *lines]))
        if says:
            with pytest.raises(BadInput, match=says):
                taken(folder)
        else:
            assert taken(folder)[0] == [i * STEP for i in range(8)]


# verifies: GND-03
@pytest.mark.parametrize(("listed", "name"), [
    ("rgb\\{i}.png", "rgb/{i}.png"), ("rgb\\IMG_{i}.PNG", "rgb/img_{i}.png"), ("rgb/gro\u0308\u00dfe{i}.png", "rgb/gr\u00f6\u00dfe{i}.png")])
def test_names_of_another_system_find_their_files(tmp_path, listed, name):
    times, said = taken(tum(tmp_path / "tum", f"{{s}} {listed}", name))
    assert times == TIMES and ("the list has names in other letters than the files have, as" in said) == ("IMG" in listed or "gro" in listed)


def test_files_that_are_not_there_are_named(tmp_path):
    folder = tum(tmp_path / "tum", "{s} rgb/{i}.png")
    for i in (2, 5):
        (folder / f"rgb/{i}.png").rename(folder / f"rgb/_{i}.png")
    source = open_source(folder, Options())
    list(Plan(source, Part()).frames())
    assert source.account.dropped == {f"listed, but the file is missing: {folder / 'rgb/2.png'} is the first": 2}
    folder = tum(tmp_path / "two", "{s} rgb/A{i}.png", "rgb/a{i}.png")
    (folder / "rgb/a0.PNG").write_bytes(b"")  # which of both is meant is not known
    source = open_source(folder, Options())
    list(Plan(source, Part()).frames())
    assert source.account.dropped == {f"listed, but the file is missing: {folder / 'rgb/A0.png'}": 1}
