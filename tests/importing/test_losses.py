"""What is lost between a source and its sequence is counted in frames and seconds; a tenth is warned of, half is refused."""

import json

import made_sources as sources
import numpy as np
import pytest
from polhode_ground.common.errors import BadInput
from polhode_ground.importing import colmap_project, video
from polhode_ground.importing.numbering import frame_numbers
from polhode_ground.importing.plan import NOT_DECODED, Part, Plan
from polhode_ground.importing.source import Account, Frame, Options, Source
from polhode_ground.importing.stamps import find_gaps

NS = sources.NS
COUNT = 40
PICTURES = [np.full((48, 64), 5 * i, np.uint8) for i in range(COUNT)]


def source_of(times_ns, comes=lambda place: True, order=None) -> Source:
    """A source whose decoder gives the frames of these places only."""
    places = [place for place in (order or range(len(times_ns))) if comes(place)]
    return Source("made", (Frame(times_ns[place]) for place in places), Account(), list(times_ns))


def read(source, **part) -> tuple[list[int], Plan]:
    plan = Plan(source, Part(**part))
    return [frame.timestamp_ns for frame in plan.frames()], plan


SECONDS = [i * NS for i in range(COUNT)]


# verifies: GND-03
def test_frames_that_a_decoder_gives_up_are_all_counted():
    times, plan = read(source_of(SECONDS, lambda place: not 20 <= place < 30))
    assert len(times) == 30 and plan.account.dropped == {NOT_DECODED: 10}
    assert plan.loss().said == "10 of 40 frames (25 %, about 10 s) are lost or missing"
    ended, plan = read(source_of(SECONDS, lambda place: place < 20))
    assert len(ended) == 20 and plan.account.dropped == {NOT_DECODED: 20} and plan.loss().is_refused


def test_what_the_source_counts_itself_is_not_counted_twice():
    source = source_of(SECONDS)

    def frames():
        for place, time in enumerate(SECONDS):
            if place in (3, 4):
                source.account.dropped["torn"] += 1
                continue
            yield Frame(time)
    source.frames = frames()
    times, plan = read(source)
    assert len(times) == COUNT - 2 and plan.account.dropped == {"torn": 2} and plan.loss().frames == 2


def test_frames_that_a_source_counts_without_a_time_are_the_gap_that_they_leave():
    for told, lost, of in ((10, 10, 40), (4, 10, 40), (14, 14, 44)):
        source = source_of([time for time in SECONDS if not 10 <= time // NS < 20])

        def frames(source=source, told=told):
            yield from map(Frame, source.times_ns)
            source.account.dropped["missing in the recording"] += told
        source.frames = frames()
        _, plan = read(source)
        assert plan.gaps.frames == 10 and (plan.loss().frames, plan.loss().of) == (lost, of)


def test_packets_that_no_frame_is_made_of_are_no_loss():
    hidden = [time for second in SECONDS for time in (second, second + NS // 2)]  # as VP8's second packets, or the second fields
    times, plan = read(source_of(hidden, lambda place: place % 2 == 0))
    assert len(times) == COUNT and not plan.account.dropped and plan.loss().frames == 0


def test_parts_are_taken_by_the_judged_times():
    bad = [0 if place == 12 else 1000 * NS + time for place, time in enumerate(SECONDS)]
    times, plan = read(source_of(bad), from_s=10, to_s=20, step=5)
    assert [time // NS for time in times] == [1010, 1016]
    assert plan.account.dropped == {"before --from": 10, "by --step": 8, "time out of line with its neighbours'": 1}
    assert plan.loss().frames == 1 and not plan.loss().is_refused
    shuffled, _ = read(source_of(SECONDS, order=[1, 0, 3, 2, *range(4, COUNT)]))
    assert sorted(shuffled) == SECONDS


def test_the_first_frame_is_taken_whatever_the_stamps_last_digits_are():
    for begin in range(1_700_000_000_123_456_700, 1_700_000_000_123_457_000, 7):
        times = [begin + i * NS for i in range(5)]
        assert read(source_of(times))[0] == times and read(source_of(times), from_s=1.0)[0] == times[1:]


def test_what_a_reader_tells_at_its_end_is_heard():
    source = source_of(SECONDS)

    def frames():
        yield from (Frame(time) for time in SECONDS)
        source.account.dropped["missing in the recording"] += 60
    source.frames = frames()
    _, plan = read(source)
    assert plan.loss().is_refused


def test_dates_and_clocks_in_names_are_no_count():
    names = [f"IMG_20260101_{clock}.jpg" for clock in ("125958", "125959", "130000", "130001")]
    frames, said = frame_numbers(names)
    assert frames == [0, 1, 2, 3] and "no count of frames" in said


def test_gaps_of_the_stamps_count_as_missing_and_never_refuse():
    _, plan = read(source_of([time for time in SECONDS if not 10 <= time // NS < 35]))
    assert plan.loss().said == "25 of 40 frames (62 %, about 25 s) are lost or missing"
    assert plan.loss().is_told and not plan.loss().is_refused


def test_a_counter_that_wraps_is_refused_until_it_is_allowed_for():
    stamps = [(2**32 * 1000 - 20 * NS + time) % (2**32 * 1000) for time in SECONDS]
    with pytest.raises(BadInput, match="begin again after picture 20 of the source, as a counter does after 4294.9673 s; --unwrap"):
        Plan(source_of(stamps), Part())
    times, _ = read(source_of(stamps), unwrap=True)
    assert set(np.diff(times)) == {NS}


def test_less_than_a_tenth_is_told_without_a_warning():
    for lost, is_told in ((3, False), (4, True)):
        _, plan = read(source_of(SECONDS, lambda place: place >= lost))
        assert plan.loss().frames == lost and plan.loss().is_told == is_told


# verifies: GND-03
def test_a_tenth_is_warned_of_in_the_last_line_and_half_is_refused(run, tmp_path):
    for count, status in ((4, 0), (20, 1)):
        folder = tmp_path / f"photos{count}"
        sources.write_pictures(folder, PICTURES, [f"{i:03d}.png" for i in range(COUNT)])
        for torn in range(count):
            (folder / f"{2 * torn:03d}.png").write_bytes(b"\x89PNG torn")
        done = run(folder, tmp_path / f"SEQ{count}", "--intrinsics", "100,100,15.5,11.5", "--rate-hz", 2)
        said = f"{count} of 40 frames ({100 * count / COUNT:.0f} %, about {count / 2:g} s) are lost or missing"
        assert done.returncode == status and f"dropped: {count} frames: picture can't be read" in done.stdout
        if status == 0:
            assert done.stderr.strip().splitlines()[-1] == f"warning: {said}"
            assert json.loads((tmp_path / f"SEQ{count}/import.json").read_text())["lost"] == said
            continue
        assert f"{said}: nothing is written; --allow-loss takes what is left" in done.stderr and not (tmp_path / "SEQ20").exists()
        allowed = run(folder, tmp_path / "SEQ20", "--intrinsics", "100,100,15.5,11.5", "--rate-hz", 2, "--allow-loss")
        assert allowed.returncode == 0 and allowed.stderr.strip().splitlines()[-1] == f"warning: {said}"


def test_one_bad_header_stamp_of_a_bag_costs_one_frame(imported, tmp_path):
    store = sources.ros_types(2)
    messages = [("/cam/image_raw", 10**15 + time, sources.image_message(store, pixels, 10**12 + time if place != 12 else 0))
                for place, (time, pixels) in enumerate(zip(SECONDS, PICTURES))]
    sources.write_bag(tmp_path / "bag", 2, messages)
    sequence, out = imported(tmp_path / "bag", "--intrinsics", "100,100,15.5,11.5")
    assert sequence.timestamp_ns.tolist() == [10**12 + time for time in SECONDS if time != 12 * NS]
    assert "dropped: 1 frames: time out of line with its neighbours'" in out


def test_a_video_lists_its_frames_in_order_of_presentation(tmp_path):
    sources.write_video(tmp_path / "clip.mkv", PICTURES, [0.1 * i for i in range(COUNT)], preset="medium")  # frames refer ahead: the file's order is another
    assert video.open_video(tmp_path / "clip.mkv", Options()).times_ns == [i * NS // 10 for i in range(COUNT)]
    source = video.open_video(tmp_path / "clip.mkv", Options())
    times, plan = read(source, from_s=1, to_s=2)
    assert times == [i * NS // 10 for i in range(10, 21)] and set(plan.account.dropped) == {"before --from"}


def test_a_video_that_is_cut_short_has_lost_its_end(tmp_path):
    rng = np.random.default_rng(1)
    noise = [rng.integers(0, 255, (48, 64), dtype=np.uint8) for _ in range(COUNT)]  # so that packets are of one size
    sources.write_video(tmp_path / "clip.mkv", noise, [0.1 * i for i in range(COUNT)])
    octets = (tmp_path / "clip.mkv").read_bytes()
    (tmp_path / "cut.mkv").write_bytes(octets[:len(octets) // 2])
    source = video.open_video(tmp_path / "cut.mkv", Options())
    assert abs(source.count - COUNT) <= 2
    _, plan = read(source)
    assert abs(plan.loss().held_share - 0.5) < 0.1


def test_pictures_that_colmap_did_not_register_leave_gaps(tmp_path):
    names = [f"{folder}/{i}.png" for folder in "ba" for i in (1, 2, 10)]
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    registered = {tmp_path / name for name in names if name not in ("a/2.png", "b/10.png")}
    files = colmap_project._all_pictures(tmp_path, registered, {tmp_path / "b/10.png"})
    assert [str(file.relative_to(tmp_path)) for file in files] == ["a/1.png", "a/2.png", "a/10.png", "b/1.png", "b/2.png"]
    account = Account()
    frames = colmap_project._registered((Frame(i, file=file) for i, file in enumerate(files)), registered, account)
    assert [frame.timestamp_ns for frame in frames] == [0, 2, 3, 4] and account.dropped == {"not registered in the COLMAP model": 1}


# verifies: GND-03
@pytest.mark.parametrize("broken", [[9, 10, 11], [4, 5], [0, 4, 5, 11]])
@pytest.mark.parametrize("exif", [None, lambda i: sources.exif_of(f"2024:05:01 10:00:{i:02d}.0")])
def test_links_to_nothing_are_lost_once(tmp_path, run, broken, exif):
    sources.write_pictures(tmp_path / "seq", [np.full((48, 64), 20 * i, np.uint8) for i in range(12)], [f"{i:03d}.jpg" for i in range(12)], exif)
    for number in broken:
        (tmp_path / f"seq/{number:03d}.jpg").unlink()
        (tmp_path / f"seq/{number:03d}.jpg").symlink_to(tmp_path / "gone.jpg")
    done = run(tmp_path / "seq", tmp_path / "SEQ", "--intrinsics", "100,100,15.5,11.5", *([] if exif else ["--rate-hz", 1]))
    assert f"dropped: {len(broken)} frames: a link to a file that is not there" in done.stdout and "missing:" not in done.stdout
    assert f"warning: {len(broken)} of 12 frames" in done.stderr
    rows = (tmp_path / "SEQ/mav0/cam0/data.csv").read_text().splitlines()[1:]
    begin = int(rows[0].split(",")[0])
    first = min(set(range(12)) - set(broken))
    assert [first + (int(row.split(",")[0]) - begin) // NS for row in rows] == [i for i in range(12) if i not in broken]


def write_avi(path, shown):
    """MJPEG whose other places are empty, as a recorder leaves them that dropped frames."""
    import fractions

    import av
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=10)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuvj420p"
        stream.codec_context.time_base = fractions.Fraction(1, 10)
        for place in shown:
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 5 * place, np.uint8), format="rgb24")
            frame.pts, frame.time_base = place, fractions.Fraction(1, 10)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


# verifies: GND-03
@pytest.mark.parametrize("dropped", [[5, 6, 13], [*range(4, 10), 18, 19, 20], [1, 3, 5, 7, 9, 11, 13]])
def test_empty_places_of_an_avi_are_lost_once(tmp_path, dropped):
    shown = [place for place in range(25) if place not in dropped]
    write_avi(tmp_path / "clip.avi", shown)
    source = video.open_video(tmp_path / "clip.avi", Options())
    times, plan = read(source)
    assert times == [place * NS // 10 for place in shown]
    assert plan.account.dropped == {"an empty place in the file: the recorder dropped it": len(dropped)} and not plan.gaps.said
    assert (plan.loss().frames, plan.loss().of) == (len(dropped), 25)


def test_a_bad_stamp_of_an_unsorted_list_is_lost_once():
    times_ns = [i * NS // 25 for i in [0, 1, 3, 2, 4, 5]] + [None] + [i * NS // 25 for i in [7, 11, 8, 9, 10]]
    assert find_gaps(times_ns, range(12)).frames == 0
    assert find_gaps([time for time in times_ns if time is not None], range(11)).frames == 1
