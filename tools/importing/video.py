"""A video by PyAV: true presentation times, turned as its rotation flag says."""

import pathlib
from collections.abc import Iterator

import numpy as np
from importing.source import NS, Account, Frame, Options, Source

from judge.errors import BadInput


def open_video(path: pathlib.Path, options: Options) -> Source:
    import av
    try:
        with av.open(str(path)) as container:
            stream = next((one for one in container.streams.video), None)
            if stream is None:
                raise BadInput(f"{path}: a media file without a video stream")
            if container.format.name == "image2" or container.format.name.endswith("_pipe"):  # FFmpeg's readers of pictures
                raise BadInput(f"{path}: found a single picture")
            rate, count = stream.average_rate, stream.frames or None
            words = f"video, {stream.codec_context.name}, {stream.width}x{stream.height}, {float(rate):.4g} frames/s" if rate else "video"
    except (av.FFmpegError, OSError) as problem:
        raise BadInput(f"{path}: not a video that can be read ({problem.strerror or problem})") from None
    account = Account()
    account.assumed.append("the time of a frame is its presentation time; a rolling shutter is not undone")
    return Source(words, _frames(path, account), account, count)


def _frames(path: pathlib.Path, account: Account) -> Iterator[Frame]:
    import av
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        decoded = container.decode(stream)
        while True:
            try:
                frame = next(decoded)
            except StopIteration:
                return
            except av.FFmpegError as problem:
                account.dropped[f"can't be decoded: {problem.strerror}"] += 1
                return  # the stream's state is lost: what follows would be of other pictures
            if frame.pts is None:
                account.dropped["no presentation time"] += 1
                continue
            # pts * time_base as whole nanoseconds, without the rounding of float
            time_ns = round(frame.pts * frame.time_base * NS)
            yield Frame(time_ns, pixels=upright(frame.to_ndarray(format="gray"), frame.rotation, account))


def upright(pixels: np.ndarray, rotation_deg: int, account: Account) -> np.ndarray:
    """Turned as a player shows it. @param rotation_deg  FFmpeg's: anticlockwise, in -180 .. 180"""
    quarters = round(rotation_deg / 90) % 4
    note = f"turned by {90 * quarters} deg anticlockwise, as the video's rotation flag says"
    if quarters and note not in account.assumed:
        account.assumed.append(note)
    return np.ascontiguousarray(np.rot90(pixels, quarters))
