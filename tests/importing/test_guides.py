"""The guides of docs/ as written: every command in them is run on sources made of the sample, and finds the sample's rates."""

import os
import pathlib
import re
import subprocess

import made_sources as sources
import numpy as np
import pytest
from made_sources import REPOSITORY, SAMPLE
from PIL import Image

PROGRAM = pathlib.Path(os.environ.get("POLHODE_PROGRAM", REPOSITORY / "build/release/bin/polhode"))
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} is not built")]
CALIBRATION = """camera_matrix: {rows: 3, cols: 3, data: [888.8888889, 0, 319.5, 0, 888.8888889, 239.5, 0, 0, 1]}
image_width: 640
image_height: 480
distortion_model: plumb_bob
distortion_coefficients: {data: [0, 0, 0, 0]}
"""
# Sigmas are those of the worst axis: a norm of three components lies within 2.80 of them on 95 % of the frames.
BOUND = 2.80


def commands_of(guide: str) -> str:
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", (REPOSITORY / "docs" / guide).read_text(), re.DOTALL | re.MULTILINE)
    commands = [text for language, text in blocks if not language]
    assert commands
    return "".join(commands)


@pytest.fixture
def desk(tmp_path):
    """A folder that looks like the repository's own from where the guides' commands are called."""
    for name in ("tools", "build", "config", "hil", ".venv"):
        (tmp_path / name).symlink_to(REPOSITORY / name)
    (tmp_path / "calibration.yaml").write_text(CALIBRATION)
    return tmp_path


def follow(desk: pathlib.Path, guide: str) -> None:
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", commands_of(guide)], cwd=desk, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """Rates of the original sequence: (speeds [N] rad/s, sigmas [N])."""
    folder = tmp_path_factory.mktemp("original") / "DIR"
    subprocess.run([PROGRAM, "replay", "--config", REPOSITORY / "config/default.toml", "--sequence", SAMPLE, "--out", folder], check=True, capture_output=True)
    return speeds(folder)


def speeds(run: pathlib.Path):
    from polhode_ground.common.tables import read_motion
    motion = read_motion(run / "motion_smoothed.csv")
    assert motion.rate_valid.all()
    return np.linalg.norm(motion.w_T, axis=1), motion.columns["sigma_rate_rad_s"]


def agrees(run: pathlib.Path, original) -> None:
    """The same speed frame by frame within both sigmas, and the same mean on the page."""
    (speed, sigma), (true_speed, true_sigma) = speeds(run), original
    assert np.mean(np.abs(speed - true_speed) <= BOUND * np.hypot(sigma, true_sigma)) >= 0.95
    found = re.search(r"<b>([\d.]+) deg/s</b>mean rate of rotation", (run / "report.html").read_text())
    assert abs(float(found.group(1)) - np.degrees(true_speed.mean())) < 0.01 + BOUND * np.degrees(np.hypot(sigma, true_sigma)).mean()


@pytest.mark.further
def test_my_video_and_my_photographs(desk, sample, original):
    frames = [sample.read_gray(index) for index in range(len(sample.filenames))]
    sources.write_video(desk / "clip.mp4", frames, range(len(frames)))
    (desk / "photos").mkdir()
    for index, pixels in enumerate(frames):
        Image.fromarray(pixels).save(desk / f"photos/IMG_{index}.jpg", quality=95)
    follow(desk, "guide_video.md")
    agrees(desk / "DIR", original)
    agrees(desk / "DIR_PHOTOS", original)
    assert (desk / "run.mp4").stat().st_size > 10_000


@pytest.mark.further
def test_my_laboratory(desk, sample, original):
    store, messages = sources.ros_types(2), []
    for index, time_ns in enumerate(sample.timestamp_ns.tolist()):
        messages.append(("/camera/image_raw", time_ns, sources.image_message(store, sample.read_gray(index), time_ns)))
        messages.append(("/camera/camera_info", time_ns, sources.info_message(store, 640, 480, [888.8888889, 0, 319.5, 0, 888.8888889, 239.5, 0, 0, 1], [0.0] * 5)))
    sources.write_bag(desk / "recording", 2, messages)
    text = commands_of("guide_laboratory.md").replace("hil/evaluate.py", f"cp {SAMPLE}/truth.csv SEQ/ && hil/evaluate.py")  # "put the path into SEQ/truth.csv"
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=desk, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "attitude RMSE [deg]" in done.stdout and "DIR/truth.tum" in done.stdout
    agrees(desk / "DIR", original)


@pytest.mark.further
def test_my_servicer(desk, original):
    (desk / "pictures").symlink_to(SAMPLE / "mav0/cam0/data")
    follow(desk, "guide_servicer.md")
    agrees(desk / "DIR", original)
    from mcap.reader import make_reader
    with open(desk / "run.mcap", "rb") as file:
        counts = make_reader(file).get_summary().statistics.channel_message_counts
        file.seek(0)
        topics = {channel.topic: counts[number] for number, channel in make_reader(file).get_summary().channels.items()}
    poses = {name: len((desk / "DIR" / name).read_text().splitlines()) for name in ("causal.tum", "smoothed.tum")}
    assert topics["/camera/image"] == 90 and topics["/target/causal"] == poses["causal.tum"] and topics["/target/smoothed"] == poses["smoothed.tum"]
    assert topics["/target/cloud"] == 1 and topics["/target/events"] > 0 and topics["/bus/packet"] > 90


@pytest.mark.further
def test_my_cluster(desk, monkeypatch):
    """SLURM's side is played by two scripts that run and end job scripts here; the sample is the sequence with truth."""
    pytest.importorskip("distributed", reason="distributed is not installed: tools/setup.sh campaign")
    pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed: tools/setup.sh campaign")
    (desk / "SEQ").symlink_to(SAMPLE)
    guide = (REPOSITORY / "docs/guide_cluster.md").read_text()
    (desk / "plan.toml").write_text(re.search(r"^```toml\n(.*?)^```$", guide, re.DOTALL | re.MULTILINE).group(1))
    example = (REPOSITORY / "hil/campaigns/slurm_example.toml").read_text()
    (desk / "slurm.toml").write_text(example.replace("jobs = 20", "jobs = 1").replace('"FILL_IN"', '"nodes"'))
    (desk / "bin").mkdir()
    (desk / "bin/sbatch").write_text(f'#!/bin/sh\ncp "$1" {desk}/job_script\nsetsid sh {desk}/job_script > {desk}/job.log 2>&1 &\necho $!\n')
    (desk / "bin/scancel").write_text('#!/bin/sh\nfor id; do kill -- -"$id" 2>/dev/null; done\nexit 0\n')
    for name in ("sbatch", "scancel"):
        (desk / "bin" / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{desk / 'bin'}:{os.environ['PATH']}")
    monkeypatch.setenv("POLHODE_CACHE", str(desk / "cache"))
    follow(desk, "guide_cluster.md")
    runs = pq.read_table(desk / "DIR/report/runs.parquet").to_pylist()
    assert len(runs) == 2 and max(run["coverage"] for run in runs) > 0.9
    assert "index.html" in {path.name for path in (desk / "DIR/report").iterdir()}
    paired = (desk / "NEW/report/paired.csv").read_text().splitlines()
    assert len(paired) > 1
