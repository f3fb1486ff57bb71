"""EXIF's orientation of pictures is not followed in a replay, and that is said once."""

import json

from PIL import Image
from polhode_ground.testing.sequence_writer import SequenceWriter, textured

ORIENTATION = 0x0112


def turn(file, orientation: int) -> None:
    """The same pixels with the word of how people should see them."""
    exif = Image.Exif()
    exif[ORIENTATION] = orientation
    octets = file.read_bytes()
    segment = exif.tobytes()
    file.write_bytes(octets[:2] + b"\xff\xe1" + (len(segment) + 2).to_bytes(2, "big") + segment + octets[2:])


def test_it_is_said_once_and_pixels_are_as_stored(replay, tmp_path):
    writer = SequenceWriter(tmp_path / "plain", ".jpg")
    files = [writer.add(textured(seed)) for seed in range(4)]
    plain = replay(writer.path, out=tmp_path / "out_plain")
    assert plain.status == 0 and "EXIF" not in plain.err
    assert json.loads((plain.folder / "summary.json").read_text())["warnings"] == []
    turn(files[0], 1)
    for file in files[1:3]:
        turn(file, 6)
    turned = replay(writer.path, out=tmp_path / "out_turned")
    assert turned.status == 0
    lines = [line for line in turned.err.splitlines() if "EXIF" in line]
    assert len(lines) == 1 and f"2 of 4 pictures have an EXIF orientation other than 1 ({files[1].name}: 6); their pixels are taken as stored" in lines[0]
    assert json.loads((turned.folder / "summary.json").read_text())["warnings"] == [lines[0].removeprefix("polhode: ")]
    assert (turned.folder / "bus.ccsds").read_bytes() == (plain.folder / "bus.ccsds").read_bytes()
