"""Every reader of the program with a good input of its own: what is spoilt, and how it is read."""

import dataclasses
import io
import pathlib
import shutil
import subprocess
import sys

from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "replay"), str(HERE.parent / "network")]
from mutations import checkpoint_sums, recording_sums  # noqa: E402
from replay_files import DEFAULTS, PROGRAM  # noqa: E402
from sequence_writer import SequenceWriter, textured  # noqa: E402

FRAMES = 3


@dataclasses.dataclass
class Reader:
    """`arguments` has {file} and {sequence} and {out}; where `place` is named, the spoilt file is put there in the sequence."""

    name: str
    good: bytes
    arguments: list[str]
    place: str = ""
    sums: object = None


def picture(kind: str) -> bytes:
    gray = Image.fromarray(textured(1))
    made = {"png": (gray, "PNG", {}), "png colour": (gray.convert("RGBA"), "PNG", {}), "png palette": (gray.convert("P"), "PNG", {}),
            "png 16": (gray.convert("I;16"), "PNG", {}), "jpeg": (gray, "JPEG", {"quality": 90}),
            "jpeg colour": (gray.convert("RGB"), "JPEG", {"quality": 90, "restart_marker_rows": 2}),
            "jpeg progressive": (gray.convert("RGB"), "JPEG", {"progressive": True}), "pgm": (gray, "PPM", {})}
    image, form, options = made[kind]
    out = io.BytesIO()
    image.save(out, form, **options)
    return out.getvalue()


def sequence(folder: pathlib.Path) -> SequenceWriter:
    writer = SequenceWriter(folder)
    for seed in range(FRAMES):
        writer.add(textured(seed // 2))
    return writer


def live_run(folder: pathlib.Path) -> tuple[bytes, bytes, bytes]:
    """@return a checkpoint, a recording and a stream of packets."""
    played = SequenceWriter(folder / "played")
    for seed in range(8):
        played.add(textured(seed // 3))
    config = folder / "live.toml"
    config.write_text(f'[device]\nsource = "{played.path}"\nsequence_speed = 0.0\n[run]\nfolder = "{folder}/run"\n'
                      f'checkpoint = "{folder}/checkpoint"\n[recording]\nfolder = "{folder}/recording"\ncomplete = true\n')
    subprocess.run([PROGRAM, "run", "--config", config], check=True, capture_output=True, timeout=120)
    recording = next((folder / "recording").glob("*.rec"))
    return (folder / "checkpoint").read_bytes(), recording.read_bytes(), (folder / "run/bus.ccsds").read_bytes()


def all_readers(folder: pathlib.Path) -> list[Reader]:
    """Inputs are made in this folder."""
    writer = sequence(folder / "good")
    camera = "mav0/cam0/"
    checkpoint, recording, packets = live_run(folder)
    replay = ["replay", "--config", str(DEFAULTS), "--sequence", "{sequence}", "--out", "{out}"]
    attitude = b"#timestamp_ns,q_IC_w,q_IC_x,q_IC_y,q_IC_z\n1000000000,1.0,0,0,0\n1100000000,0.8,0.6,0.0,0.0\n"
    commands = b"# when what\n1000000000 hold\n1100000000 resume\n1100000000 set_range range_m=12.5 frame_timestamp_ns=7\n1200000000 reset_counters\n"
    tables = [Reader("data.csv", (writer.camera / "data.csv").read_bytes(), replay, camera + "data.csv"),
              Reader("sensor.yaml", (writer.camera / "sensor.yaml").read_bytes(), replay, camera + "sensor.yaml"),
              Reader("servicer_attitude.csv", attitude, replay, "servicer_attitude.csv"),
              Reader("commands", commands, [*replay, "--commands", "{file}"]),
              Reader("configuration", DEFAULTS.read_bytes(), ["check", "--config", "{file}"]),
              Reader("live configuration", (folder / "live.toml").read_bytes(), ["check", "--config", "{file}"])]
    pictures = [Reader(kind, picture(kind), replay, camera + f"data/{writer.rows[0][1]}")
                for kind in ("png", "png colour", "png palette", "png 16", "jpeg", "jpeg colour", "jpeg progressive", "pgm")]
    states = [Reader("checkpoint", checkpoint, [*replay, "--checkpoint", "{file}"], sums=checkpoint_sums),
              Reader("recording", recording, ["recording", "export", "{folder}", "--out", "{out}"], sums=recording_sums),
              Reader("packets", packets, ["bus", "dump", "{file}"]), Reader("packets as JSON", packets, ["bus", "dump", "{file}", "--json"])]
    shutil.rmtree(folder / "played")
    return tables + pictures + states
