"""Pictures of every depth and format come out as bright as they are, by their content; what is changed or lost is said."""

import io
import struct

import cv2
import made_sources as sources
import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.common.mosaic import contrast_of, without_mosaic
from polhode_ground.importing.decoding import decode, frame_levels
from polhode_ground.importing.formats import kind_of
from polhode_ground.importing.levels import Levels
from polhode_ground.importing.source import Account, Frame

SHAPE = (48, 64)
GRAY = np.linspace(0, 255, SHAPE[0] * SHAPE[1]).round().astype(np.uint8).reshape(SHAPE)


def encoded(pixels: np.ndarray, suffix: str) -> bytes:
    done, octets = cv2.imencode(suffix, pixels)
    assert done
    return octets.tobytes()


def by_pillow(pixels: np.ndarray, kind: str, mode: str | None = None, **options) -> bytes:
    stream, picture = io.BytesIO(), Image.fromarray(pixels)
    (picture.convert(mode) if mode else picture).save(stream, kind, **options)
    return stream.getvalue()


def levelled(*pictures: np.ndarray):
    """(the frames' pixels, what was said of them)."""
    account = Account()
    frames = list(Levels(account).of(iter([Frame(index, pixels=pixels) for index, pixels in enumerate(pictures)])))
    assert [frame.timestamp_ns for frame in frames] == list(range(len(pictures)))
    return frames, " ".join(account.assumed)


def with_holes(pixels: np.ndarray) -> np.ndarray:
    pixels = pixels.copy()
    pixels[0, :2] = np.nan
    return pixels


def with_a_hot_pixel(pixels: np.ndarray) -> np.ndarray:
    pixels = pixels.copy()
    pixels[1, 1] = 1e6
    return pixels


# verifies: GND-03
@pytest.mark.parametrize(("pixels", "says"), [
    (GRAY / np.float32(255), "float32 levels, found 0 to 1: scaled to 16 bits, 0 became 0 and 1 became 65535"),
    (GRAY / 255, "float64"),
    (GRAY.astype(np.float32), "255 became 65535"),
    (GRAY * np.float32(16), "4095 became 65535"),
    (GRAY * np.float64(257), "65535 became 65535"),
    (GRAY * np.float32(8 / 255), "8 became 65535"),
    (GRAY / np.float32(127.5) - 1, "-1 became 0 and 1 became 65535"),
    (with_holes(GRAY / np.float32(255)), "0.065 % of the pixels not finite"),
    (with_a_hot_pixel(GRAY / np.float32(255)), "0.033 % of the pixels beyond were cut"),
    (GRAY.astype(np.int32) * 1000, "found 0 to 255000"),
    (GRAY.astype(np.uint32) * 16843009, "uint32"),
    ((GRAY.astype(np.int32) * 257 - 32768).astype(np.int16), "-32768 became 0 and 32767 became 65535"),
    ((GRAY.astype(np.int32) - 128).astype(np.int8), "-128 became 0"),
    (GRAY.astype(np.int16) * 16 - 5, "% of the pixels below were set to 0"),
])
def test_other_number_types_keep_their_levels(pixels, says):
    (frame,), said = levelled(pixels)
    assert says in said and frame.pixels.dtype == np.uint16 and frame.bits == 16
    ratio = frame.pixels[20:].astype(float) / GRAY[20:] / 257
    # Full scales that are not the source's: 4095 for 4080, 2^18 - 1 for 255000; and the black level of 5.
    assert 0.96 < ratio.min() and ratio.max() < 1.01
    assert len(np.unique(frame.pixels)) >= 250


def test_one_scale_holds_for_all_pictures_of_a_source():
    dark, bright = GRAY / np.float32(2550), GRAY / np.float32(255)
    frames, said = levelled(GRAY, dark, bright, GRAY.astype(np.uint16))
    assert said.count("scaled") == 1 and frames[0].pixels.dtype == np.uint8
    assert np.abs(frames[1].pixels * 10.0 - frames[2].pixels).max() <= 5  # rounding, ten times
    assert np.array_equal(frames[3].pixels, GRAY) and frames[3].bits == 0  # the replay finds its depth


@pytest.mark.parametrize("octets", [
    encoded(GRAY.astype(np.uint16) << 4, ".png"), encoded(np.dstack([GRAY.astype(np.uint16) << 4] * 3), ".png"),
    encoded(np.dstack([GRAY.astype(np.uint16) << 4] * 3), ".tif"), encoded(np.dstack([GRAY.astype(np.uint16) << 4] * 4), ".png"),
    b"P6\n64 48\n4095\n" + (np.dstack([GRAY] * 3).astype(np.uint16) << 4).astype(">u2").tobytes(),
])
def test_twelve_bits_in_sixteen_stay_as_they_are(octets):
    assert np.array_equal(decode(octets, "one").pixels, GRAY.astype(np.uint16) << 4)


@pytest.mark.parametrize("octets", [
    by_pillow(GRAY, "PNG", "P"), by_pillow(GRAY, "PNG", "LA"), by_pillow(GRAY, "PNG", "RGBA"), by_pillow(GRAY, "BMP"), by_pillow(GRAY, "GIF"),
    by_pillow(GRAY, "WEBP", lossless=True), by_pillow(GRAY, "TIFF", compression="tiff_lzw"), by_pillow(GRAY, "JPEG2000"),
    b"P2\n64 48\n255\n" + " ".join(map(str, GRAY.ravel())).encode(), by_pillow(GRAY, "JPEG", "CMYK", quality=100)])
def test_eight_bits_of_any_kind_are_read_by_their_content(octets):
    found = decode(octets, "misnamed.png").pixels
    assert found.dtype == np.uint8 and np.abs(found.astype(int) - GRAY).max() <= (2 if kind_of(octets) == "jpeg" else 0)


def tiff(pages: list[bytes], bits: int, photometric: int) -> bytes:
    """Uncompressed gray pages of SHAPE, as few libraries write them."""
    octets, link = bytearray(b"II*\0" + bytes(4)), 4
    for page in pages:
        struct.pack_into("<I", octets, link, len(octets))
        data_at = len(octets) + 2 + 9 * 12 + 4
        tags = ((256, SHAPE[1]), (257, SHAPE[0]), (258, bits), (259, 1), (262, photometric), (273, data_at), (277, 1), (278, SHAPE[0]), (279, len(page)))
        octets += struct.pack("<H", 9) + b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags) + bytes(4) + page
        link = data_at - 4
    return bytes(octets)


WIDE = GRAY.astype("<u2") * 257


@pytest.mark.parametrize(("octets", "white"), [
    (tiff([(255 - GRAY).tobytes()], 8, 0), GRAY), (tiff([(65535 - WIDE).tobytes()], 16, 0), WIDE), (tiff([WIDE.tobytes()], 16, 1), WIDE),
    (tiff([np.packbits(GRAY < 128, axis=1).tobytes()], 1, 0), np.where(GRAY < 128, 0, 255))])
def test_a_tiff_whose_zero_is_white_grows_with_the_light(octets, white):
    assert np.array_equal(decode(octets, "one.tif").pixels, white)


def test_pages_of_a_stack_are_inverted_alike(tmp_path):
    from polhode_ground.importing.source import Options
    from polhode_ground.importing.stack import open_stack
    (tmp_path / "stack.tif").write_bytes(tiff([(65535 - WIDE).tobytes(), WIDE[::-1].tobytes()], 16, 0))
    source = open_stack(tmp_path / "stack.tif", Options())
    first, second = source.frames
    assert np.array_equal(first.pixels, WIDE) and np.array_equal(second.pixels, 65535 - WIDE[::-1])
    assert any("0 is white" in sentence for sentence in source.account.assumed)


def pgm(pixels: np.ndarray) -> bytes:
    return b"P5\n# by a camera\n64 48\n%d\n" % (255 if pixels.dtype == np.uint8 else 65535) + pixels.astype(pixels.dtype.newbyteorder(">")).tobytes()


def test_netpbm_pictures_in_one_file_are_all_read(imported, tmp_path):
    assert decode(pgm(WIDE), "16 bits").pixels.dtype == np.uint16 and decode(pgm(WIDE), "16 bits").bits == 0
    (tmp_path / "all.pgm").write_bytes(pgm(GRAY) + b"\n" + pgm(GRAY[::-1]) + b"P6 64 48 255\n" + np.dstack([GRAY] * 3).tobytes())
    sequence, out = imported(tmp_path / "all.pgm", "--intrinsics", "60,60,31.5,23.5", "--rate-hz", 2)
    assert "3 Netpbm pictures in one file" in out
    assert [np.array_equal(sequence.read_gray(k), GRAY[::-1] if k == 1 else GRAY) for k in range(3)] == [True] * 3


def test_further_pictures_of_files_that_could_be_copied_are_told_and_mixed_depths_too(imported, tmp_path):
    folder = tmp_path / "photos"
    folder.mkdir()
    (folder / "1.png").write_bytes(by_pillow(GRAY, "PNG", save_all=True, append_images=[Image.fromarray(255 - GRAY)]))
    (folder / "2.pgm").write_bytes(pgm(GRAY) * 2)
    (folder / "3.png").write_bytes(encoded(GRAY.astype(np.uint16) << 4, ".png"))
    sequence, out = imported(folder, "--intrinsics", "60,60,31.5,23.5")
    assert "2 further pages of files are left out" in out and "3.png is the first that differs" in out
    assert all(np.array_equal(sequence.read_gray(k), GRAY) for k in range(3)) and sequence.depth_bits == 12


def mosaic_dng() -> bytes:
    """The least that a raw file of a camera holds: an RGGB mosaic of 12 bits."""
    raw = np.full(SHAPE, 2000, "<u2")
    values = {254: (4, 0), 256: (4, SHAPE[1]), 257: (4, SHAPE[0]), 258: (3, 16), 259: (3, 1), 262: (3, 32803), 273: (4, None), 277: (3, 1), 278: (4, SHAPE[0]),
              279: (4, raw.nbytes), 33421: (3, 2 | 2 << 16), 33422: (1, 0 | 1 << 8 | 1 << 16 | 2 << 24), 50706: (1, 1 | 4 << 8), 50717: (4, 4095)}
    counts = {33421: 2, 33422: 4, 50706: 4}
    data_at = 8 + 2 + 12 * len(values) + 4
    entries = b"".join(struct.pack("<HHII", tag, kind, counts.get(tag, 1), data_at if value is None else value) for tag, (kind, value) in sorted(values.items()))
    return b"II*\0" + struct.pack("<IH", 8, len(values)) + entries + bytes(4) + raw.tobytes()


def test_a_raw_file_is_known_by_its_content():
    pytest.importorskip("rawpy")
    found = decode(mosaic_dng(), "named.tif")
    assert found.pixels.shape == SHAPE and "developed by LibRaw" in found.remark
    with pytest.raises(BadInput, match="can't be read"):
        decode(mosaic_dng()[:300], "cut.dng")


def fits(pixels: np.ndarray, kind: str, *cards: str) -> bytes:
    """Rows from below, as FITS has them."""
    bits = {"f4": -32, "f8": -64}.get(kind, 8 * np.dtype(kind).itemsize)
    header = ("SIMPLE  = T", f"BITPIX  = {bits}", "NAXIS   = 2", "NAXIS1  = 64", "NAXIS2  = 48", *cards, "END")
    octets = "".join(card.ljust(80) for card in header).ljust(2880).encode() + pixels[::-1].astype(">" + kind).tobytes()
    return octets + bytes(-len(octets) % 2880)


def saved(pixels: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, pixels)
    return stream.getvalue()


@pytest.mark.parametrize(("octets", "pixels"), [
    (fits(GRAY, "u1"), GRAY), (fits(GRAY.astype(int) * 16 - 99, "i2"), GRAY.astype(np.int16) * 16 - 99),
    (fits(WIDE.astype(int) - 32768, "i2", "BZERO   = 32768"), WIDE.astype(np.uint16)), (fits(GRAY, "i2", "BSCALE  = 2.0E-1", "BZERO   = 5"), (GRAY * 0.2 + 5).astype(np.float32)),
    (fits(GRAY / 255, "f4"), (GRAY / 255).astype(np.float32)), (saved(GRAY.astype(np.uint16) << 4), GRAY.astype(np.uint16) << 4),
    (saved(np.dstack([GRAY] * 3)), GRAY), (saved(GRAY / 255), GRAY / 255),
    (b"P7\nWIDTH 64\nHEIGHT 48\nDEPTH 1\nMAXVAL 4095\nTUPLTYPE GRAYSCALE\nENDHDR\n" + (GRAY.astype(np.uint16) << 4).astype(">u2").tobytes(), (GRAY * (16 * 65535 / 4095)).round().astype(np.uint16))])
def test_archives_and_laboratories_formats(octets, pixels):
    found = decode(octets, "one").pixels
    assert found.dtype == pixels.dtype and np.allclose(found, pixels, rtol=1e-6, atol=1 if found.dtype == np.uint16 else 0)


def test_an_array_that_is_no_picture_and_a_kind_that_is_not_read():
    with pytest.raises(BadInput, match="a NumPy array of 3x48x64, needed are rows, columns"):
        decode(saved(np.zeros((3, 48, 64))), "one")
    with pytest.raises(BadInput, match="a jpeg xl file that can't be read \\(damaged, or of a kind that is not known"):
        decode(b"\xff\x0a" + bytes(90), "one")


def test_films_and_phones_formats(tmp_path):
    import av
    import pillow_heif
    pillow_heif.register_heif_opener()
    heic = by_pillow(np.dstack([GRAY] * 3), "HEIF", quality=-1)
    assert kind_of(heic) == "heic" and np.abs(decode(heic, "a.jpg").pixels.astype(int) - GRAY).max() <= 1
    with av.open(str(tmp_path / "a.exr"), "w", format="image2", options={"update": "1"}) as container:
        stream = container.add_stream("exr", rate=1)
        stream.width, stream.height, stream.pix_fmt = SHAPE[1], SHAPE[0], "grayf32le"
        frame = av.VideoFrame.from_ndarray(GRAY / np.float32(255), format="grayf32le")
        container.mux([*stream.encode(frame), *stream.encode(None)])
    assert np.allclose(decode((tmp_path / "a.exr").read_bytes(), "a.exr").pixels, GRAY / 255)


# verifies: GND-03
@pytest.mark.parametrize("depth", ["half", "float"])
@pytest.mark.parametrize("form", ["grayf32le", "gbrpf32le", "gbrapf32le"])
def test_levels_of_exr_beyond_1_and_nan_are_seen(tmp_path, depth, form):
    import av
    light = with_holes(GRAY / np.float32(255) * 4)
    with av.open(str(tmp_path / "a.exr"), "w", format="image2", options={"update": "1"}) as container:
        stream = container.add_stream("exr", rate=1, options={"format": depth})
        stream.width, stream.height, stream.pix_fmt = SHAPE[1], SHAPE[0], form
        frame = av.VideoFrame(SHAPE[1], SHAPE[0], form)
        for plane, share in zip(frame.planes, (1, 0.5, 0.25, 1)):  # green, blue, red
            plane.update(np.pad(light * np.float32(share), ((0, 0), (0, plane.line_size // 4 - SHAPE[1]))).tobytes())
        container.mux([*stream.encode(frame), *stream.encode(None)])
    found = decode((tmp_path / "a.exr").read_bytes(), "a.exr").pixels
    share = 1 if form.startswith("gray") else 0.587 + 0.5 * 0.114 + 0.25 * 0.299
    assert np.allclose(found, light * share, rtol=1e-3, equal_nan=True)
    (frame,), said = levelled(found)
    assert f"found 0 to {4 * share:.3f}".rstrip("0.") in said and "0.065 % of the pixels not finite" in said and frame.pixels.max() == 65535


def test_what_is_turned_or_has_pages_is_said():
    exif = Image.Exif()
    exif[0x0112] = 6
    deep = GRAY.astype(np.uint16) << 4
    assert np.array_equal(decode(by_pillow(deep, "PNG", exif=exif), "one").pixels, np.rot90(deep, -1))
    assert np.array_equal(decode(by_pillow(deep, "TIFF", tiffinfo={0x0112: 6}), "one").pixels, np.rot90(deep, -1))
    assert decode(by_pillow(GRAY, "GIF", save_all=True, append_images=[Image.fromarray(255 - GRAY)]), "one").pages == 2


@pytest.mark.parametrize(("octets", "says"), [
    (b"hello", "not a picture"), (b"\x89PNG\r\n\x1a\ntorn", "a png file that can't be read"), (encoded(GRAY, ".tif")[:200], "a tiff file that can't be read"),
    (b"\x76\x2f\x31\x01torn", "a exr file that can't be read"), (b"II*\0" + bytes(40), "a tiff file that can't be read"),
])
def test_damaged_files_get_a_reason(octets, says):
    with pytest.raises(BadInput, match=says):
        decode(octets, "one")


# verifies: GND-03
def test_a_folder_of_misnamed_pictures(imported, tmp_path):
    files = {"1.jpg": by_pillow(GRAY, "WEBP", lossless=True), "2.png": encoded(GRAY, ".tif"), "3.pgm": by_pillow(GRAY, "PNG"), "4": encoded(GRAY / np.float32(255), ".tif"),
             "5.png": by_pillow(GRAY, "TIFF", save_all=True, append_images=[Image.fromarray(GRAY)] * 2), "6.jpg": b"<html>", "notes.txt": b"hello"}
    (tmp_path / "photos").mkdir()
    for name, octets in files.items():
        (tmp_path / "photos" / name).write_bytes(octets)
    sequence, out = imported(tmp_path / "photos", "--intrinsics", "60,60,31.5,23.5")
    assert len(sequence.filenames) == 5 and all(kind_of(sequence.frame_path(i).read_bytes()) == "png" for i in range(5))
    assert all(np.array_equal(sequence.read_gray(i), GRAY) for i in range(5))
    for words in ("float32 levels", "2 further pages of files", "1 files are no pictures: notes.txt", "1 frames: picture can't be read", "6.jpg: not a picture"):
        assert words in out, out


def test_a_tiff_of_several_pages_is_a_sequence(imported, tmp_path):
    pages = [Image.fromarray((np.roll(GRAY, k, 0) / 255).astype(np.float32)) for k in range(3)]
    pages[0].save(tmp_path / "stack.tif", save_all=True, append_images=pages[1:])
    sequence, out = imported(tmp_path / "stack.tif", "--intrinsics", "60,60,31.5,23.5", "--rate-hz", 2)
    assert np.diff(sequence.timestamp_ns).tolist() == [sources.NS // 2] * 2 and "TIFF of 3 pages" in out
    assert all(np.array_equal(sequence.read_gray(k), np.roll(GRAY, k, 0)) for k in range(3))


@pytest.mark.parametrize(("made", "into", "bits"), [
    (GRAY, "yuv420p", 8), (GRAY.astype(np.uint16) * 257, "gray12le", 16), (GRAY.astype(np.uint16) * 257, "yuv422p10le", 16), (GRAY.astype(np.uint16) << 4, "gray16le", 0),
    (GRAY.astype(np.uint16) * 257, "gbrp16le", 16)])
def test_frames_of_a_video_keep_their_depth(made, into, bits):
    import av
    frame = av.VideoFrame.from_ndarray(made, format="gray16le" if made.dtype == np.uint16 else "gray").reformat(format=into)
    found = frame_levels(frame)
    assert found.bits == (bits or 0) and found.pixels.dtype == made.dtype
    # FFmpeg goes by the limited range of 8 bits between colours and gray.
    assert np.abs(found.pixels.astype(int) - made).max() <= made.max() / (1000 if into.startswith("gray") else 200)
    assert len(np.unique(found.pixels)) >= 215


def mosaic(pixels: np.ndarray) -> np.ndarray:
    gains = np.tile([[1.0, 0.75], [0.75, 0.45]], (pixels.shape[0] // 2, pixels.shape[1] // 2))
    return np.round(pixels * gains).astype(pixels.dtype)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_mosaic_is_told_from_texture_and_taken_out(sample, kind):
    gray = sample.read_gray(30).astype(kind) << (0 if kind == np.uint8 else 4)
    assert contrast_of(gray) == 0 and contrast_of(mosaic(gray)) > 0.5
    assert contrast_of(without_mosaic(mosaic(gray))) == 0
    uniform = np.full((40, 40), 100, kind)
    assert np.abs(without_mosaic(mosaic(uniform))[1:-1, 1:-1].astype(float) - 100 * 2.95 / 4).max() <= 1


# verifies: GND-03
@pytest.mark.parametrize(("said", "levelled"), [("bayer_rggb8; png compressed bayer_rggb8", True), ("bayer_rggb8", True), ("mono8; png compressed mono8", False), ("png", False)])
def test_a_compressed_mosaic_becomes_gray_as_its_format_says(said, levelled):
    from polhode_ground.importing.bag import decoded
    account, raw = Account(), mosaic(np.full(SHAPE, 200, np.uint8))
    found = decoded(encoded(raw, ".png"), said, account)
    assert (np.ptp(found[4:-4, 4:-4].astype(int)) < 5) == levelled and bool(account.assumed) == levelled
    assert decoded(encoded(np.dstack([raw] * 3), ".png"), said).tolist() == raw.tolist()  # colours: no mosaic any more


def test_a_mosaic_is_levelled_before_the_lens_is_undone(imported, sample, tmp_path):
    raw = [mosaic(sample.read_gray(index)) for index in (20, 30)]
    sources.write_pictures(tmp_path / "photos", raw, ["1.png", "2.png"])
    (tmp_path / "lens.yaml").write_text("camera_matrix: {data: [900, 0, 319.5, 0, 900, 239.5, 0, 0, 1]}\nimage_width: 640\nimage_height: 480\n"
                                        "distortion_model: equidistant\ndistortion_coefficients: {data: [0, 0, 0, 0]}\n")
    sequence, out = imported(tmp_path / "photos", "--intrinsics", tmp_path / "lens.yaml")
    assert "mosaic does: levelled" in out and contrast_of(sequence.read_gray(0)) == 0


def test_an_undistorted_edge_is_no_new_level_of_the_camera(imported, tmp_path):
    """Cubic interpolation overshoots: 4095 must not become more, which would be taken for 14 bits."""
    edge = np.where(np.arange(640)[None, :] // 20 % 2, 4095, 0).repeat(480, 0).astype(np.uint16)
    sources.write_pictures(tmp_path / "photos", [edge], ["1.png"])
    (tmp_path / "lens.yaml").write_text("camera_matrix: {data: [900, 0, 319.5, 0, 900, 239.5, 0, 0, 1]}\nimage_width: 640\nimage_height: 480\n"
                                        "distortion_model: equidistant\ndistortion_coefficients: {data: [0.1, 0, 0, 0]}\n")
    sequence, _ = imported(tmp_path / "photos", "--intrinsics", tmp_path / "lens.yaml")
    assert np.asarray(Image.open(sequence.frame_path(0))).max() == 4095




def test_transparency_is_told_whatever_holds_it():
    wide = np.zeros((8, 8, 4), np.uint16)
    wide[..., :3] = 3000
    assert decode(cv2.imencode(".png", wide)[1].tobytes(), "wide").remark == "transparency is left out: transparent pixels show the colour that the file has below them"
    palette, octets = Image.new("P", (8, 8)), io.BytesIO()
    palette.putpalette([255, 0, 255] + [0] * 765)
    palette.save(octets, "PNG", transparency=0)
    assert decode(octets.getvalue(), "palette").remark == "transparency is left out: transparent pixels show the colour that the file has below them"


def test_names_that_are_not_utf_8_and_digits_of_other_scripts_are_taken(tmp_path):
    from polhode_ground.importing.decoding import read_picture
    from polhode_ground.importing.pictures import natural_order
    folder = tmp_path / "b\udce4"
    folder.mkdir()
    Image.fromarray(np.full((8, 8), 9, np.uint8)).save(tmp_path / "one.tif")
    (tmp_path / "one.tif").rename(folder / "one.tif")
    assert read_picture(folder / "one.tif").pixels[0, 0] == 9
    assert natural_order(folder / "\u2460000.png") < natural_order(folder / "\u2460001.png")


def test_what_a_folder_holds_beside_its_pictures_is_told(tmp_path):
    from polhode_ground.importing.pictures import in_folder
    folder = tmp_path / "pictures"
    for name in ("0.png", "below/a.png"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(np.zeros((8, 8), np.uint8)).save(folder / name)
    (folder / "1.png").symlink_to(folder / "not_there.png")
    account = Account()
    assert [path.name for path in in_folder(folder, account)] == ["0.png", "1.png"]  # a link to nothing has a place in the series
    assert account.assumed == ["1 folders with pictures below this one are left out: below"]


def test_true_is_as_bright_in_an_array_as_in_a_picture_of_one_bit():
    mask, octets, picture = np.eye(8, dtype=bool), io.BytesIO(), io.BytesIO()
    np.save(octets, mask)
    Image.fromarray(mask).save(picture, "PNG")
    found, same = decode(octets.getvalue(), "array"), decode(picture.getvalue(), "picture")
    assert np.array_equal(found.pixels, np.where(mask, 255, 0)) and np.array_equal(found.pixels, same.pixels) and found.remark == same.remark != ""
