"""Judges what a job of the virtual machine has left, on the host. Prints a line for each thing that was shown.

usage: judge.py JOB RESULTS     status 1 when something is not as it must be
"""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy
from PIL import Image

from polhode_ground.common.venv import REPOSITORY

PROGRAM = REPOSITORY / "build/v4l2_vm/bin/polhode"
NOT_EMULATED = "AVX512_SKX"  # vector units of the host that the guest does not have
SETTINGS = ["--set", "features.count_max=250", "--set", "features.working_pixels_max=40000"]  # as in jobs/common.inc


def require(true: bool, what: str) -> None:
    if not true:
        print(f"NOT SO: {what}")
        sys.exit(1)


def report(folder: pathlib.Path) -> dict:
    return json.loads((folder / "run.json").read_text())


def images(sequence: pathlib.Path) -> list[tuple[int, numpy.ndarray]]:
    camera = sequence / "mav0/cam0"
    with open(camera / "data.csv", newline="") as file:
        rows = [row for row in csv.reader(file) if not row[0].startswith("#")]
    return [(int(stamp), numpy.array(Image.open(camera / "data" / name))) for stamp, name in rows]


def exported(folder: pathlib.Path) -> list[tuple[int, numpy.ndarray]]:
    out = folder / "exported"
    shutil.rmtree(out, ignore_errors=True)
    subprocess.run([PROGRAM, "recording", "export", folder / "recording", "--out", out], check=True, capture_output=True)
    return images(out)


def replayed(sequence: pathlib.Path, out: pathlib.Path) -> bytes:
    shutil.rmtree(out, ignore_errors=True)
    config = out.parent / "defaults.toml"  # the program's own, as in the guest
    config.write_text("")
    subprocess.run(
        ["nice", PROGRAM, "replay", "--config", config, "--sequence", sequence, "--out", out, *SETTINGS],
        check=True,
        capture_output=True,
        env=os.environ | {"OPENCV_CPU_DISABLE": NOT_EMULATED},
    )
    return (out / "bus.ccsds").read_bytes()


def compliance(results: pathlib.Path) -> None:
    """The job has judged itself."""


def capture(results: pathlib.Path) -> None:
    for name, source in (("GREY", "noise8"), ("Y16", "noise16"), ("Y12", "noise16"), ("Y10", "noise16")):
        fed = images(results / "sequences" / source)
        got = exported(results / f"filecam_{name}")
        require(len(got) == len(fed), f"{name}: {len(got)} frames of {len(fed)}")
        for (fed_ns, fed_pixels), (got_ns, got_pixels) in zip(fed, got):
            require(fed_ns == got_ns, f"{name}: time {got_ns} instead of {fed_ns}")
            require(numpy.array_equal(fed_pixels, got_pixels), f"{name}: other pixels at {fed_ns}")
        print(f"test camera, {name}: 8 of 8 frames octet for octet, times of mid-exposure exact")
    for name in ("GREY", "Y16", "Y12", "Y10", "YUYV", "RGB24"):
        got = exported(results / f"vivid_{name}")
        counts = report(results / f"vivid_{name}")["camera"]
        require(len(got) == 4 and counts["frames_damaged"] == 0, f"vivid {name}")
        deep = got[0][1].dtype != numpy.uint8
        require(deep == name.startswith("Y1"), f"vivid {name}: depth")
        contrast = float(numpy.std(got[0][1])) / (65535.0 if deep else 255.0)
        require(contrast > 0.1, f"vivid {name}: no picture")
    print("vivid: GREY, Y16, Y12, Y10, YUYV, RGB24 captured")
    full = report(results / "full_hd")
    outside = full["outside_cpu_us"]
    lost = full["camera"]["frames_missing"] + full["camera"]["frames_late"]
    print(
        f"1080p GREY at 30 Hz: {full['frames_accepted']} frames, {lost} lost; outside the step p50 {outside['p50'] / 1000:.2f} ms, "
        f"p99 {outside['p99'] / 1000:.2f} ms of the guest's processor"
    )
    require(outside["p99"] < 2000, "under 2 ms a frame outside the estimator")


def planes(results: pathlib.Path) -> None:
    for name in ("GREY", "NV12M", "NV12", "UYVY", "YUV420M", "NV16M"):
        got = exported(results / f"planes_{name}")
        require(len(got) == 4 and report(results / f"planes_{name}")["camera"]["frames_damaged"] == 0, f"planes {name}")
        require(float(numpy.std(got[0][1])) > 25, f"planes {name}: no picture")
    print("vivid of several planes: GREY, NV12M, NV12, UYVY, YUV420M, NV16M captured; interlaced fields refused by name")


def run(results: pathlib.Path) -> None:
    live = (results / "live/bus.ccsds").read_bytes()
    truth = replayed(results / "sequences/body", results / "replay")
    about = report(results / "live")
    require(live == truth, f"the bus stream of the replay: {len(live)} octets, {len(truth)} expected")
    print(
        f"the bus stream of {about['frames_accepted']} frames through /dev/video0 is the replay's, {len(live)} octets; "
        f"{about['frames_with_pose']} poses"
    )
    latency = about["latency_us"]
    print(f"frame available to packet, virtual time: p50 {latency['p50'] / 1000:.1f} ms, p99 {latency['p99'] / 1000:.1f} ms")


def faults(results: pathlib.Path) -> None:
    about = report(results / "faults")
    counts = about["camera"]
    require(about["frames_accepted"] == 24, f"all frames: {about['frames_accepted']}")
    expected = {"frames_damaged": 1, "frames_missing": 3, "disconnects": 1}
    for key, number in expected.items():
        require(counts[key] == number, f"{key} is {counts[key]}, {number} expected")
    require(counts["stream_errors"] in (1, 2), f"stream_errors {counts['stream_errors']}")  # 2: the pause of 3 s is silence
    spoiled = results / "spoiled"
    shutil.rmtree(spoiled, ignore_errors=True)
    shutil.copytree(results / "sequences/body", spoiled)
    sorted((spoiled / "mav0/cam0/data").iterdir())[6].write_bytes(b"damaged")
    require((results / "faults/bus.ccsds").read_bytes() == replayed(spoiled, results / "replay"), "the replay's bus stream")
    print(
        f"error flag, gap, fatal error, unplugged for 1.5 s, silent for 3 s: 24 of 24 frames, the replay's bus stream; "
        f"{about['frames_with_pose']} poses"
    )
    second = report(results / "killed/2")
    first_err = (results / "killed/stderr1.txt").read_text()
    require("busy" in first_err, "the first start has found the device busy")
    require(second["start"].startswith("warm"), second["start"])
    require(second["first_pose_frame"] is not None and second["first_pose_frame"] < 3, "a pose within 3 frames")
    print(f"busy device waited for; SIGKILL at frame 12: {second['start']}, pose on frame {second['first_pose_frame'] + 1} after it")
    cycles = report(results / "cycles")
    rows = [list(map(int, line.split())) for line in (results / "cycles/growth.txt").read_text().splitlines() if len(line.split()) == 3]
    rows = [row for row in rows if row[0] > 0]
    early, late = rows[len(rows) // 4], rows[-2]
    require(cycles["camera"]["disconnects"] == 10, f"{cycles['camera']['disconnects']} disconnects")
    require(cycles["frames_accepted"] == 8, f"{cycles['frames_accepted']} of 8 frames")
    require("/dev/video1" in (results / "cycles/stderr.txt").read_text(), "found under its other number")
    first, second = rows[: len(rows) // 2], rows[len(rows) // 2 :]
    require(max(row[2] for row in second) <= max(row[2] for row in first), "descriptors grow")
    require(max(row[1] for row in second) <= max(row[1] for row in first), "mapped memory grows")
    require(late[0] <= early[0] * 1.01 + 64, f"memory grows from {early[0]} to {late[0]} kB")
    print(
        f"10 times unplugged and back, under another number: 8 of 8 frames, resident {early[0]} kB then {late[0]} kB, mapped at "
        f"most {max(row[1] for row in rows)} kB, at most {max(row[2] for row in rows)} descriptors"
    )


def service(results: pathlib.Path) -> None:
    about = report(results)
    require(about["start"].startswith("warm"), about["start"])
    require(about["first_pose_frame"] is not None and about["first_pose_frame"] < 3, "a pose within 3 frames")
    print(f"its second start: {about['start']}, {about['frames_accepted']} frames, pose on frame {about['first_pose_frame'] + 1}")


DECODE = """
import json, sys, polhode_bus
with polhode_bus.open_bus("file:" + sys.argv[1]) as bus:
    packets = list(bus.packets(timeout_s=1.0))
    modes = [packet.mode for packet in packets if packet.name == "housekeeping"]
    print(json.dumps({"names": [packet.name for packet in packets], "missing": bus.missing, "modes": modes}))
"""


def package(results: pathlib.Path) -> None:
    """By the client of the ground package, as it is installed in the guest's root."""
    about = report(results)
    client = REPOSITORY / "build/v4l2_vm/package_root/usr/lib/python3/dist-packages"
    done = subprocess.run(
        [sys.executable, "-c", DECODE, results / "bus.ccsds"],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": str(client)},
    )
    decoded = json.loads(done.stdout)
    names, modes = decoded["names"], decoded["modes"]
    require(about["frames_accepted"] > 0 and names.count("motion") == about["frames_accepted"], "a packet of motion for every frame")
    require(len(modes) > 0 and decoded["missing"] == 0, "housekeeping, and no packet missing")
    print(
        f"the packaged unit, {about['start']}: {about['frames_accepted']} frames; decoded by the ground package: {len(names)} packets, "
        f"{len(modes)} of housekeeping, the first in mode {modes[0]}"
    )


BRIGHT = 0.8 * 255  # where the controller puts the level that a fiftieth of the target's pixels exceed
SETTLED = 0.2  # its dead band, the gain's steps, the mask's edge


def exposure(results: pathlib.Path) -> None:
    """The sensor's account has a line a frame: number, exposure [us], gain, light, bright level, saturated pixels."""
    about = report(results / "exposure")
    rows = [[float(word) for word in line.split()] for line in (results / "exposure/sensor.txt").read_text().splitlines()]
    require(len(rows) == about["frames_accepted"] == 48, f"all frames: {about['frames_accepted']}")
    brightened = next(int(row[0]) for row in rows if row[3] != rows[0][3])

    def settled_at(first: int, last: int) -> int:
        """Frames from the change of light until the level is where it shall be, and stays."""
        off = [i for i in range(first, last) if abs(rows[i][4] / BRIGHT - 1.0) > SETTLED]
        return (off[-1] + 1 if off else first) - first

    dark, bright = settled_at(0, brightened), settled_at(brightened, len(rows))
    require(abs(rows[0][4] / BRIGHT - 1.0) > 0.5, "too dark at first")
    require(max(row[1] for row in rows) <= 50_000, "no longer exposed than a frame's time")
    require(dark <= brightened - 4, f"the level is not reached before the light changes: {[row[4] for row in rows]}")
    require(bright <= len(rows) - brightened - 4, f"nor after it: {[row[4] for row in rows]}")
    print(
        f"sixteen times too dark: level reached after {dark} frames; four times the light: after {bright}; "
        f"{about['exposure_changes']} settings made, {about['frames_with_pose']} poses"
    )


if __name__ == "__main__":
    jobs = {
        "compliance": compliance,
        "capture": capture,
        "planes": planes,
        "run": run,
        "faults": faults,
        "exposure": exposure,
        "service": service,
        "package": package,
    }
    jobs[sys.argv[1]](pathlib.Path(sys.argv[2]))
