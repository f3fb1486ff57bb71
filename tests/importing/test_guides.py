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
    blocks = re.findall(r"^```\n(.*?)^```$", (REPOSITORY / "docs" / guide).read_text(), re.DOTALL | re.MULTILINE)
    assert blocks
    return "".join(blocks)


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
    from judge.tables import read_motion
    motion = read_motion(run / "motion_smoothed.csv")
    assert motion.rate_valid.all()
    return np.linalg.norm(motion.w_T, axis=1), motion.columns["sigma_rate_rad_s"]


def agrees(run: pathlib.Path, original) -> None:
    """The same speed frame by frame within both sigmas, and the same mean on the page."""
    (speed, sigma), (true_speed, true_sigma) = speeds(run), original
    assert np.mean(np.abs(speed - true_speed) <= BOUND * np.hypot(sigma, true_sigma)) >= 0.95
    found = re.search(r"<b>([\d.]+) deg/s</b>mean rate of rotation", (run / "report.html").read_text())
    assert abs(float(found.group(1)) - np.degrees(true_speed.mean())) < 0.01 + BOUND * np.degrees(np.hypot(sigma, true_sigma)).mean()


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


def test_my_servicer(desk, original):
    (desk / "pictures").symlink_to(SAMPLE / "mav0/cam0/data")
    follow(desk, "guide_servicer.md")
    agrees(desk / "DIR", original)
    assert (desk / "run.mcap").stat().st_size > 1_000_000
