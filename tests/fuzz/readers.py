"""Every reader of the program, and those of the tools that read its clouds, with a good input: what is spoilt, and how it is read."""

import dataclasses
import io
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import zlib

import numpy
from mutations import checkpoint_sums, recording_sums
from PIL import Image
from polhode_ground.testing.replay_files import DEFAULTS, PROGRAM
from polhode_ground.testing.sequence_writer import HEIGHT, WIDTH, SequenceWriter, textured

HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]

FRAMES = 3

# Sanitizers end a program with 1, which is a status of ours. Freed memory is kept for them to find a late use: 16 MB instead of 256. What a component
# holds is no leak: it lies in memory of its own, where no sanitizer looks, and nothing is given back piece by piece when a program ends.
SANITIZERS = {"ASAN_OPTIONS": "exitcode=86:quarantine_size_mb=16:detect_leaks=0", "UBSAN_OPTIONS": "exitcode=86:print_stacktrace=1"}


@dataclasses.dataclass
class Reader:
    """`arguments` has {file} and {sequence} and {out}; where `place` is named, the spoilt file is put there in the sequence.

    `beside` are good files of the same folder by name, `file_name` is the spoilt one's where it has to have one.
    """

    name: str
    good: bytes
    arguments: list[str]
    place: str = ""
    sums: object = None
    command: tuple = (str(PROGRAM),)
    who: str = "polhode"  # a refusal begins with it
    beside: dict = dataclasses.field(default_factory=dict)
    file_name: str = "input"
    seconds_max: float = 20.0


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
    subprocess.run([PROGRAM, "run", "--config", config], check=True, capture_output=True, timeout=120, env=os.environ | SANITIZERS)
    recording = next((folder / "recording").glob("*.rec"))
    return (folder / "checkpoint").read_bytes(), recording.read_bytes(), (folder / "run/bus.ccsds").read_bytes()


def ply(count: int, columns: dict) -> bytes:
    """Points as the program writes them; columns: name -> array [count] of float32, uint8 or int32."""
    kinds = {"float32": "float", "uint8": "uchar", "int32": "int"}
    names = [f"property {kinds[str(values.dtype)]} {name}" for name, values in columns.items()]
    rows = numpy.rec.fromarrays(list(columns.values()), dtype=[(name, values.dtype) for name, values in columns.items()])
    return "\n".join(["ply", "format binary_little_endian 1.0", f"element vertex {count}", *names, "end_header", ""]).encode() + rows.tobytes()


def surface_readers(folder: pathlib.Path) -> list[Reader]:
    """tools/surface.py on the clouds of a run; none where pycolmap is not installed, which it would fetch."""
    if not (REPOSITORY / ".venv-colmap/bin/python3").exists():
        return []
    from polhode_ground.testing.synthetic import Errors, tumbling_body, write_run
    run = write_run(folder / "judged", tumbling_body(frames=6), Errors())
    count = 300
    normals = numpy.random.default_rng(1).normal(size=(count, 3)).astype(numpy.float32)
    normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    places = {name: normals[:, i] for i, name in enumerate("xyz")}
    clouds = {"cloud.ply": ply(count, places | {f"n{name}": normals[:, i] for i, name in enumerate("xyz")} | {"added": numpy.zeros(count, numpy.uint8)}),
              "cloud_raw.ply": ply(count, places | {"landmark": numpy.arange(count, dtype=numpy.int32)})}
    others = {name: (run / name).read_bytes() for name in ("motion_smoothed.csv", "observations.csv")}
    return [Reader(f"surface of {name}", clouds[name], ["{folder}"], command=(sys.executable, str(REPOSITORY / "tools/surface.py")), who="surface",
                   beside=others | clouds, file_name=name, seconds_max=60.0) for name in clouds]


def live_readers(checkpoint: bytes) -> list[Reader]:
    """What a live run finds beside its configuration: its key, numbers of commands, checkpoint and mark of a crash, and the picture of the servicer."""
    key = b"0123456789abcdef" * 4 + b"\n"
    config = (b'[device]\nsequence_speed = 0.0\n[run]\nlock_memory = false\ncore = -1\npriority = 0\n')
    beside = {"live.toml": config, "key": key}
    run = ["run", "--config", "{folder}/live.toml", "--set", 'device.source="{sequence}"', "--set", 'run.folder="{out}"']
    guarded = [*run, "--set", 'transport.receive="unix:{folder}/port"', "--set", 'commands.key="{folder}/key"', "--set", 'commands.window="{folder}/window"']
    restarted = [*run, "--set", 'run.checkpoint="{folder}/checkpoint"']
    place = struct.pack("<8sQQ", b"PLHNUM01", 5, 7)  # platform/transport/number_file.cpp
    mark = struct.pack("<4sIII", b"PLCM", 1, zlib.crc32(checkpoint[:236]), 0)  # platform/app/crash_mark.cpp
    own = Image.new("L", (WIDTH, HEIGHT))
    own.paste(255, (0, 0, WIDTH // 4, HEIGHT))
    drawn = io.BytesIO()
    own.save(drawn, "PNG")
    replay = ["replay", "--config", str(DEFAULTS), "--sequence", "{sequence}", "--out", "{out}"]
    return [Reader("picture of the servicer", drawn.getvalue(), [*replay, "--set", 'mask.file="{file}"']),
            Reader("key of a run", key, guarded, beside=beside, file_name="key"),
            Reader("numbers of commands", 2 * (place + struct.pack("<II", zlib.crc32(place), 0)), guarded, beside=beside, file_name="window"),
            Reader("checkpoint of a run", checkpoint, restarted, sums=checkpoint_sums, beside=beside, file_name="checkpoint"),
            Reader("mark of a crash", mark + struct.pack("<I", zlib.crc32(mark)), restarted, beside={**beside, "checkpoint": checkpoint},
                   file_name="checkpoint.crashed"),
            Reader("key of a sender", key, ["bus", "send", "unix:{folder}/port", "noop", "--key", "{file}"])]


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
              Reader("recording", recording, ["recording", "export", "{folder}", "--out", "{out}"], sums=recording_sums, file_name="recording-1-000001.rec"),
              Reader("packets", packets, ["bus", "dump", "{file}"]), Reader("packets as JSON", packets, ["bus", "dump", "{file}", "--json"]),
              Reader("packets followed", packets, ["bus", "follow", "file:{file}", "--json", "--timeout", "0.05"])]
    shutil.rmtree(folder / "played")
    return tables + pictures + states + live_readers(checkpoint) + surface_readers(folder)
