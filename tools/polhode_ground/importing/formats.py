"""Which kind of picture a file is, by its first octets: names are often wrong."""

import pathlib

# What `polhode replay` reads, with the suffix that such a file should have.
READ_BY_REPLAY = {"png": ".png", "jpeg": ".jpg", "pgm": ".pgm"}
BEGIN_OCTETS = 32
BEGINNINGS = (
    (b"\x89PNG\r\n\x1a\n", "png"),
    (b"\xff\xd8\xff", "jpeg"),
    (b"P5", "pgm"),
    (b"II*\0", "tiff"),
    (b"MM\0*", "tiff"),
    (b"II+\0", "tiff"),
    (b"MM\0+", "tiff"),
    (b"BM", "bmp"),
    (b"GIF8", "gif"),
    (b"P1", "pnm"),
    (b"P2", "pnm"),
    (b"P3", "pnm"),
    (b"P4", "pnm"),
    (b"P6", "pnm"),
    (b"Pf", "pnm"),
    (b"PF", "pnm"),
    (b"P7\n", "pam"),
    (b"\x93NUMPY", "numpy"),
    (b"\0\0\0\x0cjP  ", "jpeg 2000"),
    (b"\xff\x4f\xff\x51", "jpeg 2000"),
    (b"#?RADIANCE", "hdr"),
    (b"#?RGBE", "hdr"),
    (b"\x76\x2f\x31\x01", "exr"),
    (b"SDPX", "dpx"),
    (b"XPDS", "dpx"),
    (b"SIMPLE  =", "fits"),
    (b"FUJIFILMCCD-RAW", "raw"),
    (b"IIU\0", "raw"),
    (b"IIRO", "raw"),
    (b"IIRS", "raw"),
    (b"MMOR", "raw"),
    (b"8BPS", "psd"),
    (b"\xff\x0a", "jpeg xl"),
    (b"\0\0\0\x0cJXL ", "jpeg xl"),
)
# ISO base media files say what they are behind "ftyp".
BRANDS = {
    b"avif": "avif",
    b"avis": "avif",
    b"heic": "heic",
    b"heix": "heic",
    b"heim": "heic",
    b"heis": "heic",
    b"hevc": "heic",
    b"mif1": "heic",
    b"msf1": "heic",
    b"crx ": "raw",
}
# Raw files of cameras that begin like a TIFF.
RAW_SUFFIXES = (".dng", ".nef", ".nrw", ".arw", ".sr2", ".cr2", ".pef", ".iiq", ".3fr", ".erf", ".kdc", ".dcr", ".mos", ".rwl", ".srw")


def kind_of(octets: bytes) -> str | None:
    """The kind of picture that begins so; None where it is none that is known."""
    if octets[:4] == b"RIFF" and octets[8:12] == b"WEBP":
        return "webp"
    if octets[4:8] == b"ftyp":
        return BRANDS.get(octets[8:12])
    kind = next((kind for beginning, kind in BEGINNINGS if octets.startswith(beginning)), None)
    # Two letters are few: a netpbm file goes on with a blank.
    return None if kind in ("pgm", "pnm") and not octets[2:3].isspace() else kind


def kind_of_file(path: pathlib.Path) -> str | None:
    try:
        with open(path, "rb") as stream:
            return kind_of(stream.read(BEGIN_OCTETS))
    except OSError:
        return None
