"""Videos that are damaged, cut, bare, interlaced or mirrored: what can be shown whole is taken at its time, all else is counted and told."""

import numpy as np
import pytest
from made_sources import NS
from PIL import Image

COUNT, GROUP, RATE = 24, 8, 25
WIDTH, HEIGHT = 160, 120
DAMAGED, MISSING = "damaged, or built on a damaged frame", "missing in the file, whose header promises them"


def picture(index: int) -> np.ndarray:
    """A textured square on its way over a dark ground."""
    rng = np.random.default_rng(7)
    pixels = np.full((HEIGHT, WIDTH), 30, np.uint8)
    pixels[20:84, 8 + 2 * index:72 + 2 * index] = rng.integers(60, 250, (16, 16), np.uint8).repeat(4, 0).repeat(4, 1)
    return pixels


PICTURES = [picture(index) for index in range(COUNT)]


ENCODERS = {"h264": ("libx264", {"crf": "16", "bf": "0", "sc_threshold": "0"}), "h264_b": ("libx264", {"crf": "16", "bf": "2", "sc_threshold": "0"}),
            "hevc": ("libx265", {"crf": "16", "x265-params": f"log-level=none:keyint={GROUP}:scenecut=0"}), "mpeg4": ("mpeg4", {"qscale": "3"}),
            "mjpeg": ("mjpeg", {}, "yuvj420p"), "vp9": ("libvpx-vp9", {"deadline": "realtime", "lag-in-frames": "0"}), "mpeg2": ("mpeg2video", {"qscale": "3"})}


def write(path, coding="h264", keep=lambda index: True, spoil=None, container_options=None):
    """@param spoil  (number of a packet, place in it): a third of it becomes ones from there"""
    import av
    with av.open(str(path), "w", options=container_options or {}) as container:
        encoder, options, *pixel_format = ENCODERS[coding]
        stream = container.add_stream(encoder, rate=RATE, options=options)
        stream.width, stream.height, stream.pix_fmt, stream.codec_context.gop_size = WIDTH, HEIGHT, (pixel_format or ["yuv420p"])[0], GROUP
        number = 0
        for pixels in [*PICTURES, None]:
            frame = None if pixels is None else av.VideoFrame.from_ndarray(pixels, format="gray").reformat(format=stream.pix_fmt)
            for packet in stream.encode(frame):
                if keep(number):
                    container.mux(spoilt(packet, spoil[1]) if spoil and spoil[0] == number else packet)
                number += 1
    return path


def spoilt(packet, place: float):
    """What follows of a packet of Annex B's form is kept in one piece: its start codes stay."""
    import av
    octets = bytearray(bytes(packet))
    begin = 6 + int(place * (len(octets) - 6))
    end = min(len(octets), begin + max(20, len(octets) // 3))
    octets[begin:end] = b"\xff" * (end - begin)
    other = av.Packet(bytes(octets))
    other.pts, other.dts, other.duration, other.time_base, other.stream = packet.pts, packet.dts, packet.duration, packet.time_base, packet.stream
    other.is_keyframe = packet.is_keyframe
    return other


def read(path, **options):
    """(pixels by number of the frame, what was dropped, all that is said)."""
    from polhode_ground.importing.recognise import open_source
    from polhode_ground.importing.source import Options
    source = open_source(path, Options(**options))
    frames = list(source.frames)
    times = [frame.timestamp_ns for frame in frames]
    assert times == sorted(times) and set(times) <= set(source.times_ns)
    first = source.times_ns[0]
    return {round((time - first) * RATE / NS): frame.pixels for time, frame in zip(times, frames)}, dict(source.account.dropped), " ".join(source.account.assumed)


def differing(found, whole) -> list[int]:
    return [number for number, pixels in found.items() if np.abs(pixels.astype(int) - whole[number]).max() > 40]


# verifies: GND-03
@pytest.mark.parametrize("place", [0.0, 0.5])
@pytest.mark.parametrize(("coding", "suffix"), [("h264", "mp4"), ("h264_b", "mkv"), ("h264_b", "ts"), ("mpeg4", "avi"), ("mpeg2", "mpg"), ("mjpeg", "avi")])
def test_damage_costs_the_frames_to_the_next_key_frame(tmp_path, coding, suffix, place):
    whole, dropped, _ = read(write(tmp_path / f"whole.{suffix}", coding))
    assert len(whole) == COUNT and not dropped
    found, dropped, said = read(write(tmp_path / f"spoilt.{suffix}", coding, spoil=(10, place)))
    assert not differing(found, whole)
    assert len(found) + dropped[DAMAGED] == COUNT and dropped.keys() == {DAMAGED}
    assert dropped[DAMAGED] <= (1 if coding == "mjpeg" else GROUP)
    assert set(range(2 * GROUP, COUNT)) <= set(found) and set(range(GROUP)) <= set(found)
    assert f"{dropped[DAMAGED]} frames are left out, to the next key frame at" in said


@pytest.mark.parametrize(("coding", "suffix"), [("h264", "mp4"), ("hevc", "mp4"), ("mpeg4", "mp4"), ("vp9", "mkv"), ("mpeg2", "ts")])
def test_packets_that_are_missing_are_noticed(tmp_path, coding, suffix):
    whole, _, _ = read(write(tmp_path / f"whole.{suffix}", coding))
    found, dropped, said = read(write(tmp_path / f"missing.{suffix}", coding, keep=lambda number: number not in (10, 11, 12)))
    told = "earlier pictures are missing" in said or "Could not find ref" in said
    assert not differing(found, whole) and told if coding in ("h264", "hevc") else "frames are missing before 0.5" in said
    assert set(range(2 * GROUP, COUNT)) <= set(found)


@pytest.mark.parametrize(("coding", "suffix", "options"), [
    ("h264", "mkv", None), ("mjpeg", "avi", None), ("h264_b", "mp4", {"movflags": "faststart"}), ("mjpeg", "mov", {"movflags": "faststart"})])
def test_a_cut_video_tells_all_that_is_missing(tmp_path, coding, suffix, options):
    path = write(tmp_path / f"whole.{suffix}", coding, container_options=options)
    octets = path.read_bytes()
    (tmp_path / f"cut.{suffix}").write_bytes(octets[:len(octets) * 6 // 10])
    found, dropped, _ = read(tmp_path / f"cut.{suffix}")
    assert 4 < len(found) < COUNT and len(found) + sum(dropped.values()) == COUNT and dropped[MISSING] > 3


def test_a_stream_that_begins_between_key_frames_begins_at_the_next(tmp_path):
    whole, _, _ = read(write(tmp_path / "whole.ts"))
    found, dropped, _ = read(write(tmp_path / "late.ts", keep=lambda number: number >= 3))
    assert list(found) == list(range(GROUP - 3, COUNT - 3)) and sum(dropped.values()) == GROUP - 3
    assert not differing({number + 3: pixels for number, pixels in found.items()}, whole)


def test_a_complaint_is_heard_again_in_the_next_file(tmp_path):
    path = write(tmp_path / "spoilt.avi", "mjpeg", spoil=(10, 0.5))
    assert read(path)[1] == read(path)[1] == {DAMAGED: 1}


@pytest.mark.parametrize(("content", "says"), [
    (b"", "an empty file"), (b"hello, this is text\n" * 20, "its content is not what its name says"),
    (b"\0\0\0\x20ftypisom" + bytes(20) + b"\0\0\x10\0mdat" + bytes(4000), "its index, the box moov, is missing: the recording was not closed")])
def test_files_that_are_named_like_a_video(tmp_path, content, says):
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.recognise import open_source
    from polhode_ground.importing.source import Options
    (tmp_path / "clip.mp4").write_bytes(content)
    with pytest.raises(BadInput, match=says):
        open_source(tmp_path / "clip.mp4", Options())


# verifies: GND-03
@pytest.mark.parametrize(("coding", "suffix"), [("h264_b", "h264"), ("hevc", "hevc"), ("mjpeg", "mjpeg")])
def test_bare_streams_take_their_times_from_the_rate(tmp_path, coding, suffix):
    path = write(tmp_path / f"bare.{suffix}", coding)
    found, dropped, said = read(path, rate_hz=50.0)
    assert max(found) == round((COUNT - 1) * RATE / 50)
    assert "50 frames a second, as --rate-hz says" in said and not dropped
    found, _, said = read(path)
    if coding == "mjpeg":
        assert list(found) == [number * RATE for number in range(COUNT)] and "rates and velocity are per picture: give --rate-hz" in said
    else:
        assert list(found) == list(range(COUNT)) and "25 frames a second, as its header says" in said


def test_a_bare_stream_keeps_its_times_over_damage(tmp_path):
    whole, _, _ = read(write(tmp_path / "whole.h264"))
    found, dropped, _ = read(write(tmp_path / "bare.h264", spoil=(10, 0.5)))
    assert not differing(found, whole) and len(found) + dropped[DAMAGED] == COUNT and max(found) == COUNT - 1


def test_a_rate_for_a_video_that_tells_its_times_is_left_out(tmp_path):
    found, _, said = read(write(tmp_path / "clip.mp4"), rate_hz=3.0)
    assert list(found) == list(range(COUNT)) and "--rate-hz is left out" in said


def test_frames_that_nobody_asked_for_are_no_loss(tmp_path):
    """The decoder holds some back when the reader stops early."""
    from polhode_ground.importing.recognise import open_source
    from polhode_ground.importing.source import Options
    source = open_source(write(tmp_path / "clip.mkv", "h264_b"), Options())
    for _ in range(5):
        next(source.frames)
    before = list(source.account.assumed)
    source.frames.close()
    assert source.account.assumed == before and not source.account.dropped


def test_an_avi_with_frames_out_of_order_has_steady_times(tmp_path):
    found, _, _ = read(write(tmp_path / "clip.avi", "h264_b"))
    assert list(found) == list(range(COUNT)) and all(np.abs(found[i].astype(int) - PICTURES[i]).mean() < 4 for i in found)


def test_what_an_edit_list_leaves_out_is_said(tmp_path):
    import av
    with av.open(str(write(tmp_path / "clip.mp4", "h264_b"))) as source, av.open(str(tmp_path / "edited.mp4"), "w") as target:
        stream = target.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                packet.pts, packet.dts = (ticks - round(3 / RATE / packet.time_base) for ticks in (packet.pts, packet.dts))
                target.mux(packet)
    found, dropped, _ = read(tmp_path / "edited.mp4")
    assert len(found) == COUNT - 3 and dropped == {"left out by the video's edit list": 3}


def test_of_interlaced_frames_one_field_is_taken():
    from polhode_ground.importing.shown import first_field
    rows = np.array([[0], [99], [20], [99], [41], [99]], np.uint8)
    assert first_field(rows).ravel().tolist() == [0, 10, 20, 31, 41, 41]
    assert first_field(rows[:5]).ravel().tolist() == [0, 10, 20, 31, 41]


def test_interlaced_video_is_told(tmp_path):
    ENCODERS["interlaced"] = ("libx264", {"crf": "16", "flags": "+ildct+ilme", "x264-params": "tff=1"})
    _, _, said = read(write(tmp_path / "clip.mp4", "interlaced"))
    assert "interlaced: the two fields are of different times" in said


@pytest.mark.parametrize(("matrix", "shown"), [
    ((-1, 0, 0, 1), lambda pixels: pixels[:, ::-1]), ((1, 0, 0, -1), lambda pixels: pixels[::-1]),
    ((0, 1, 1, 0), lambda pixels: pixels.T), ((0, -1, -1, 0), lambda pixels: pixels[::-1, ::-1].T)])
def test_a_display_matrix_that_mirrors_is_obeyed_and_told(tmp_path, matrix, shown):
    """Over x' = a x + c y, y' = b x + d y (ISO 14496-12, tkhd)."""
    path = write(tmp_path / "clip.mp4")
    plain, _, _ = read(path)
    octets = bytearray(path.read_bytes())
    at = octets.index(b"tkhd") + 4 + 4 + 36
    for place, value in zip((0, 4, 12, 16), matrix):
        octets[at + place:at + place + 4] = (value * 65536).to_bytes(4, "big", signed=True)
    path.write_bytes(octets)
    found, _, said = read(path)
    assert np.array_equal(found[0], shown(plain[0])) and "mirrored, as the video's display matrix says" in said


def write_tracks(path, sizes, **tags):
    """Of one picture each, of levels 0, 100, 200. @param tags  a list for the tracks each"""
    import av
    with av.open(str(path), "w") as container:
        streams = [container.add_stream("mpeg4", rate=RATE) for _ in sizes]
        for number, (stream, size) in enumerate(zip(streams, sizes)):
            stream.width, stream.height, stream.pix_fmt = size, size, "yuv420p"
            stream.metadata.update({name: values[number] for name, values in tags.items()})
        for number, stream in enumerate(streams):
            frame = av.VideoFrame.from_ndarray(np.full((stream.height, stream.width), 100 * number, np.uint8), format="gray").reformat(format="yuv420p")
            for packet in [*stream.encode(frame), *stream.encode(None)]:
                container.mux(packet)


def test_the_largest_of_several_videos_is_taken(tmp_path):
    write_tracks(tmp_path / "two.mkv", (48, 96))
    found, _, said = read(tmp_path / "two.mkv")
    assert found[0].shape == (96, 96) and "2 videos in one file: number 0, 48x48, number 1, 96x96; number 1 is taken, --camera 0 takes number 0" in said


# verifies: GND-03
def test_another_track_of_a_video_is_taken_where_the_user_says_so(tmp_path, imported, refused):
    write_tracks(tmp_path / "two.mkv", (64, 64, 64), title=["left", "right", "right"], language=["eng", "fra", "deu"])
    for camera, number in (("1", 1), ("cam2", 2), ("left", 0), ("LEFT", 0), ("fra", 1)):
        sequence, out = imported(tmp_path / "two.mkv", "--intrinsics", "80,80,31.5,31.5", "--camera", camera, name=f"SEQ_{camera}")
        assert abs(float(sequence.read_gray(0).mean()) - 100 * number) < 8 and f"number {number} is taken" in out
    for camera, count in (("3", 0), ("middle", 0), ("right", 2)):
        line = refused(tmp_path / "two.mkv", "--intrinsics", "80,80,31.5,31.5", "--camera", camera)
        assert f"number 2, 64x64 (right deu); {count} of them are called '{camera}': --camera takes a number, a title or a language" in line


def test_the_rate_that_is_told_is_that_of_the_times(tmp_path):
    import av
    with av.open(str(tmp_path / "clip.dv"), "w") as container:  # its header says 60000 frames a second
        stream = container.add_stream("dvvideo", rate=25)
        stream.width, stream.height, stream.pix_fmt = 720, 576, "yuv420p"
        for number in range(6):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.full((576, 720), 30 * number, np.uint8), format="gray").reformat(format="yuv420p")))
        container.mux(stream.encode(None))
    from polhode_ground.importing.recognise import open_source
    from polhode_ground.importing.source import Options
    source = open_source(tmp_path / "clip.dv", Options())
    assert source.kind == "video, dvvideo, 720x576, 25 frames/s" and np.diff(source.times_ns).tolist() == [40_000_000] * 5


@pytest.mark.parametrize("name", ["clip.webp", "clip.gif", "clip.png"])
def test_animated_pictures_are_videos(tmp_path, name):
    frames = [Image.fromarray(pixels) for pixels in PICTURES]
    frames[0].save(tmp_path / name, save_all=True, append_images=frames[1:], duration=1000 // RATE, **({"lossless": True} if name.endswith("webp") else {}))
    found, dropped, _ = read(tmp_path / name)
    assert list(found) == list(range(COUNT)) and not dropped
    assert all(np.abs(found[number].astype(int) - PICTURES[number]).max() <= 1 for number in found)


def test_complaints_beside_the_picture_are_none():
    import av.logging as log
    from polhode_ground.importing.packets import complaint
    assert complaint([(log.ERROR, "mjpeg", "unable to decode APP fields: Invalid data\n"), (log.ERROR, "h264", "SEI type 5 size 2208 truncated at 2200\n"),
                      (log.WARNING, "mjpeg", "EOI missing, emulating\n"), (log.DEBUG, "h264", "nal_unit_type: 1\n")]) == ""
    assert complaint([(log.INFO, "h264", "concealing 12 DC, 12 AC, 12 MV errors in P frame\n")]) == "h264: concealing 12 DC, 12 AC, 12 MV errors in P frame"
    assert complaint([(log.DEBUG, "h264", "Frame num gap 9 5\n")]) == "h264: earlier pictures are missing"
