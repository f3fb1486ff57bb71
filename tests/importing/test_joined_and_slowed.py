"""Videos that play at another rate than they were taken at, that were put one behind the other, that end within a picture."""

import made_sources as sources
import numpy as np
import pytest
from made_sources import NS
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Options

PICTURES = [np.full((48, 64), 20 * i, np.uint8) for i in range(8)]
CODECS = {"flv": "flv1", "wmv": "wmv2", "avi": "mjpeg", "y4m": "wrapped_avframe"}


def written(path, tags=None, options=None):
    import av
    with av.open(str(path), "w", format="yuv4mpegpipe" if path.suffix == ".y4m" else None, options=options or {}) as container:
        container.metadata.update(tags or {})
        codec = CODECS.get(path.suffix[1:], "mpeg4")
        stream = container.add_stream(codec, rate=30)
        stream.height, stream.width = PICTURES[0].shape
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        for pixels in PICTURES:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="gray").reformat(format=stream.pix_fmt)))
        container.mux(stream.encode(None))
    return path


def opened(path):
    source = open_source(path, Options())
    return source, " ".join(source.account.assumed)


# verifies: GND-03
@pytest.mark.parametrize(("suffix", "options"), [
    ("mp4", {}), ("mp4", {"movflags": "frag_keyframe+empty_moov"}), ("mov", {}), ("mkv", {}), ("mkv", {"live": "1"}), ("webm", {}), ("flv", {}), ("wmv", {}), ("avi", {})])
def test_videos_one_behind_the_other_are_refused_with_the_place(tmp_path, suffix, options):
    CODECS["webm"] = "libvpx"
    octets = written(tmp_path / f"one.{suffix}", options=options).read_bytes()
    assert len(opened(tmp_path / f"one.{suffix}")[0].times_ns) == len(PICTURES)
    (tmp_path / f"two.{suffix}").write_bytes(2 * octets)
    with pytest.raises(BadInput, match=f"2 videos one behind the other in one file, the second from octet {len(octets)} on.*concat`$"):
        open_source(tmp_path / f"two.{suffix}", Options())


@pytest.mark.parametrize(("fps", "step_ns"), [("240.000000", NS / 240), ("1", NS), ("30.0", NS / 30), ("nonsense", NS / 30)])
def test_the_rate_of_the_camera_gives_the_times(tmp_path, fps, step_ns):
    source, said = opened(written(tmp_path / "slow.mp4", {"com.android.capture.fps": fps}, {"movflags": "use_metadata_tags"}))
    assert np.allclose(np.diff(source.times_ns), step_ns, atol=2) and ("tells that the camera took" in said) == (step_ns != NS / 30)
    assert [frame.timestamp_ns for frame in source.frames] == source.times_ns


def test_the_xml_of_a_camera_tells_slow_motion(tmp_path):
    path = written(tmp_path / "slow.mp4")
    xml = b'<NonRealTimeMeta><VideoFrame videoCodec="AVC" captureFps="119.88p" formatFps="29.97p"/></NonRealTimeMeta>'
    path.write_bytes(path.read_bytes() + (8 + len(xml)).to_bytes(4, "big") + b"meta" + xml)
    source, said = opened(path)
    assert np.allclose(np.diff(source.times_ns), NS / 120, atol=2) and "took 119.88 frames a second, played at 29.97: times are 4 times shorter" in said


def test_a_time_lapse_without_a_rate_is_told(tmp_path):
    _, said = opened(written(tmp_path / "lapse.mp4", {"com.apple.photos.captureMode": "Time-lapse"}, {"movflags": "use_metadata_tags"}))
    assert "the video is a time lapse" in said


def test_a_picture_that_is_cut_is_missing(tmp_path):
    octets = written(tmp_path / "whole.y4m").read_bytes()
    source, _ = opened(tmp_path / "whole.y4m")
    assert len(list(source.frames)) == len(PICTURES) and not source.account.dropped
    (tmp_path / "cut.y4m").write_bytes(octets[:-2000])
    source, _ = opened(tmp_path / "cut.y4m")
    assert len(list(source.frames)) == len(PICTURES) - 1 and source.account.dropped.total() == 1


def test_a_display_matrix_between_quarters_is_told(tmp_path):
    sources.write_video(tmp_path / "clip.mp4", PICTURES, [0.1 * i for i in range(8)])
    octets = bytearray((tmp_path / "clip.mp4").read_bytes())
    at = octets.index(b"tkhd") + 4 + 4 + 36
    for place, value in zip((0, 4, 12, 16), (1, 1, -1, 1)):
        octets[at + place:at + place + 4] = round(value * 0.5**0.5 * 65536).to_bytes(4, "big", signed=True)
    (tmp_path / "clip.mp4").write_bytes(octets)
    source, _ = opened(tmp_path / "clip.mp4")
    assert next(source.frames).pixels.shape == (48, 64) and "turns by -45 deg: only quarters are undone" in " ".join(source.account.assumed)
