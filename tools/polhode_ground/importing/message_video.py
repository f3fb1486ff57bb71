"""Video in messages: one message holds what belongs to one frame, as Foxglove's CompressedVideo and ROS' FFMPEGPacket have it."""

from collections.abc import Iterator

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.decoding import frame_levels
from polhode_ground.importing.packets import Decoder
from polhode_ground.importing.source import Account, Frame

# Parts of the formats' names, and FFmpeg's decoder. FFMPEGPacket names encoders, such as hevc_nvenc.
CODECS = {"264": "h264", "265": "hevc", "hevc": "hevc", "vp8": "vp8", "vp9": "vp9", "av1": "libdav1d"}


def codec_of(message) -> str | None:
    """FFmpeg's name of the message's codec; None where it is no video."""
    name = getattr(message, "format", getattr(message, "encoding", "")).split(";")[0].lower()
    return next((codec for part, codec in CODECS.items() if part in name), None)


class MessageVideo:
    def __init__(self, where: str, account: Account):
        self._where, self._account = where, account
        self._decoder, self._codec, self._times_ns = None, None, []

    def feed(self, message, time_ns: int) -> Iterator[Frame]:
        import av

        codec = codec_of(message)
        if codec is None or codec != (self._codec or codec):
            said = getattr(message, "format", getattr(message, "encoding", ""))
            raise BadInput(f"{self._where}: video of format '{said}', allowed is one of h264, h265, vp8, vp9, av1 throughout")
        if self._decoder is None:
            self._codec, self._decoder = codec, Decoder(av.CodecContext.create(codec, "r"), self._account)
        self._times_ns.append(time_ns)
        yield from self._frames(self._decoder.feed(av.Packet(bytes(message.data)), time_ns))

    def _frames(self, pictures) -> Iterator[Frame]:
        for picture in pictures:
            levels = frame_levels(picture.frame)
            self._account.note(levels.remark)
            yield Frame(self._times_ns[picture.packet], pixels=levels.pixels, bits=levels.bits)

    def finish(self) -> Iterator[Frame]:
        if self._decoder is not None:
            yield from self._frames(self._decoder.feed(None))
            self._decoder.finish()
