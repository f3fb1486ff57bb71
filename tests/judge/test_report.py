"""The page of a run: warnings first, whole without any other file, sensible for every kind of run, legible in a browser."""

import csv
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from polhode_ground.testing.synthetic import Errors, box_points, tumbling_body, write_acquired, write_motion, write_ply, write_run

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PAGE_OCTETS_MAX = 15_000_000


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(sequence, run), see write_acquired()."""
    return write_acquired(tmp_path_factory.mktemp("report"), frames=40)


@pytest.fixture
def run(made, tmp_path):
    return pathlib.Path(shutil.copytree(made[1], tmp_path / "run"))


def report(*arguments) -> tuple[int, str]:
    done = subprocess.run([sys.executable, REPOSITORY / "tools/report.py", *map(str, arguments)], capture_output=True, text=True)
    return done.returncode, done.stderr


def text_of(run: pathlib.Path) -> str:
    """What the page says, without scripts and tags."""
    text = (run / "report.html").read_text()
    return html.unescape(" ".join(re.sub(r"<[^>]+>", " ", re.sub(r"<(script|style).*?</\1>", " ", text, flags=re.DOTALL)).split()))


def made_of(run, *arguments) -> str:
    status, err = report(run, *arguments)
    assert status == 0, err
    return text_of(run)


def test_a_good_run_has_no_warning_and_all_of_its_parts(run):
    text = made_of(run)
    for title in ("What the camera saw", "When what happened", "How it turns", "How it moves", "How wrong it is", "The motion as a law",
                  "What it looks like", "What each frame gave", "What it cost", "Against the truth, in figures"):
        assert title in text
    assert "Nothing needs a warning" in text and "Know this first" not in text
    page = (run / "report.html").read_text()
    assert page.count("data:image/jpeg;base64,") == 8
    outside = re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="(?!data:)([^"]*)"', re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL))
    assert outside == []


def test_warnings_come_first_and_say_what_is_wrong(made, run, tmp_path):
    sequence = pathlib.Path(shutil.copytree(made[0], tmp_path / "seq"))
    (sequence / "import.json").write_text(json.dumps({"nominal_time": True, "intrinsics_from": "EXIF of a.jpg (X: 28 mm equivalent)"}))
    summary = json.loads((run / "summary.json").read_text())
    summary |= {"mode_at_end": "LOST", "counters": {"frames_in": 40, "frames_used": 39, "frames_dark": 2}, "deadline": {"missed": 3}}
    (run / "summary.json").write_text(json.dumps(summary))
    (run / "shape.json").write_text(json.dumps({"scale": {"known": False}, "unit": "map_units"}))
    (run / "motion_model.json").write_text(json.dumps({"fit": {"status": "too_few_poses"}}))
    text = made_of(run, "--sequence", sequence)
    for warning in ("the target is not seen (mode LOST)", "map units of unknown size", "Rates, periods and velocity are per picture",
                    "wrong by some per cent", "2 dark", "3 frames took longer", "not accepted (too few poses)"):
        assert warning in text, warning
    assert text.index("Know this first") < text.index("What the camera saw")


def test_sigmas_that_promise_too_much_are_told(made, run):
    with open(run / "motion.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    for row in rows[3:]:
        row["sigma_att_rad"] = "1e-4"
    with open(run / "motion.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    assert "causal: the attitude is within the 95 % bound of its sigma on 0 % of the frames only" in made_of(run)


def test_a_run_that_never_acquired(made, tmp_path):
    write_run(tmp_path / "lost", tumbling_body(frames=40), Errors(first_frame=999), sequence=made[0])
    (tmp_path / "lost/cloud.ply").unlink()
    (tmp_path / "lost/shape.json").write_text(json.dumps({"scale": {"known": False}, "unit": "map_units"}))
    (tmp_path / "lost/motion_model.json").write_text(json.dumps({"fit": {"status": "refused: too few poses"}}))
    text = made_of(tmp_path / "lost")
    assert "The target was never acquired" in text and "0 of 40" in text and "There is nothing to draw" in text
    assert "The scale is not known" not in text and "torque-free motion was not accepted" not in text and "Drag to turn" not in text
    assert "no pose" in text and "What each frame gave" in text and "nan" not in text.lower().split()


def test_a_run_without_truth(made, run, tmp_path):
    sequence = pathlib.Path(shutil.copytree(made[0], tmp_path / "seq"))
    (sequence / "truth.csv").unlink()
    text = made_of(run, "--sequence", sequence)
    assert "How wrong it is" not in text and "Against the truth" not in text and "How it turns" in text


def test_a_run_whose_sequence_is_gone(run):
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps(summary | {"sequence": "gone"}))
    text = made_of(run)
    assert "can't be read, so no frames are shown" in text and "What the camera saw" not in text


def test_long_times_are_whole_numbers(run):
    summary = json.loads((run / "summary.json").read_text())
    summary["timings"]["step"]["max_us"] = 9_214_000
    (run / "summary.json").write_text(json.dumps(summary))
    text = made_of(run)
    assert "time of a step, longest 9 214 ms" in text and "e+0" not in text


def test_a_run_that_fell_into_two_frames_T(run):
    text = (run / "motion.csv").read_text().splitlines()
    (run / "motion.csv").write_text("\n".join([*text[:21], *(line.removesuffix(",1") + ",2" if line.endswith(",1") else line for line in text[21:])]) + "\n")
    assert "attitudes are in 2 different frames of the target" in made_of(run)


@pytest.mark.further
def test_a_long_run_is_thinned(tmp_path):
    errors = Errors(attitude_rms_rad=0.01, position_rms_m=0.02, rate_rms_rad_s=0.001, velocity_rms_m_s=0.001)
    body = tumbling_body(frames=20_000, step_s=0.1, velocity_m_s=(0, 0, 0))
    (tmp_path / "long").mkdir()
    for name in ("motion.csv", "motion_smoothed.csv"):
        write_motion(tmp_path / "long" / name, body, errors)
    write_ply(tmp_path / "long/cloud.ply", box_points(50_000))
    assert "20000 of 20000" in made_of(tmp_path / "long")
    assert (tmp_path / "long/report.html").stat().st_size < PAGE_OCTETS_MAX


def test_thinning_keeps_outliers_and_breaks():
    from polhode_ground.reporting.figures import POINTS_MAX, thinned
    seconds, value = np.arange(20_000.0), np.zeros(20_000)
    value[7777], value[12_345] = 9.0, np.nan
    thin_s, thin = thinned(seconds, value)
    assert len(thin) <= 3 * POINTS_MAX and 9.0 in thin and np.isnan(thin).any() and 7777.0 in thin_s


@pytest.mark.parametrize(("arguments", "says"), [(["/nonexistent"], "no such run folder"), (["RUN", "--sequence", "/nonexistent"], "no such sequence folder"),
                                                 (["RUN", "--out", "/dev/null/page"], "/dev/null/page"), (["RUN", "--truth", "/nonexistent"], "nonexistent")])
def test_bad_arguments_get_one_line(run, arguments, says):
    status, err = report(*(run if argument == "RUN" else argument for argument in arguments))
    assert status == 2 and says in err and err.count("\n") == 1, err


@pytest.mark.further
@pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed")
@pytest.mark.parametrize("width_px", [1280, 390])
def test_a_browser_shows_it_without_errors(run, tmp_path, width_px):
    browser = pytest.importorskip("browser")
    made_of(run)
    page = (run / "report.html").read_text()
    catch = "<script>window.faults = []; addEventListener('error', e => faults.push(e.message)); console.error = (...a) => faults.push(a.join(' '));</script>"
    (run / "report.html").write_text(page.replace("<head>", f"<head>{catch}", 1))
    with browser.open_page(f"file://{run / 'report.html'}", tmp_path / "profile", width_px, 900) as shown:
        shown._ask("Emulation.setDeviceMetricsOverride", width=width_px, height=900, deviceScaleFactor=1, mobile=width_px < 500)
        shown.wait_for("document.readyState == 'complete' && document.querySelectorAll('.main-svg').length > 10", 30)
        assert shown.value("faults.join('; ')") == ""
        assert shown.value("document.documentElement.scrollWidth") <= width_px  # nothing sticks out to the side
        assert shown.value("Math.min(...Array.from(document.querySelectorAll('p, td, li'), e => parseFloat(getComputedStyle(e).fontSize)))") >= 12
        shown.screenshot(tmp_path / "page.png")
    from PIL import Image
    assert np.asarray(Image.open(tmp_path / "page.png").convert("L")).std() > 20


def test_a_video_shows_the_frames_with_what_was_found(made, run, tmp_path):
    import av
    (run / "surface.ply").write_bytes((made[0] / "model.ply").read_bytes())
    status, err = report(run, "--video", tmp_path / "run.mp4")
    assert status == 0, err
    from polhode_ground.common.sequence import read_sequence
    with av.open(str(tmp_path / "run.mp4")) as container:
        shown = [frame.to_ndarray(format="rgb24").astype(int) for frame in container.decode(video=0)]
    assert len(shown) == 40
    sequence = read_sequence(made[0])
    coloured = [np.ptp(frame, axis=2) > 60 for frame in shown]  # frames are gray: colour is what was drawn
    assert coloured[0].sum() < coloured[20].sum() and coloured[20].sum() > 300  # frame 0 has no pose
    body = sequence.read_gray(20) > 100
    drawn = np.flatnonzero(coloured[20].any(axis=0))
    seen = np.flatnonzero(body.any(axis=0))
    assert abs(drawn[0] - seen[0]) < 25 and abs(drawn[-1] - seen[-1]) < 60  # the axes stand out to one side


def test_a_fine_surface_does_not_hide_the_picture():
    import trimesh
    from polhode_ground.common.sequence import Camera
    from polhode_ground.reporting.video import draw_surface
    from scipy.spatial.transform import Rotation
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.5)
    checks = np.repeat(np.repeat(np.indices((30, 40)).sum(axis=0) % 2, 8, axis=0), 8, axis=1).astype(np.uint8) * 150 + 50
    picture = np.repeat(checks[:, :, None], 3, axis=2)
    camera = Camera(320, 240, np.array([500.0, 500.0, 159.5, 119.5]), np.zeros(4))
    draw_surface(picture, camera, Rotation.identity(), np.array([0, 0, 4.0]), (ball.vertices, ball.faces))
    coloured = np.ptp(picture.astype(int), axis=2) > 10
    rows, columns = np.flatnonzero(coloured.any(axis=1)), np.flatnonzero(coloured.any(axis=0))
    radius_px = 500 * 0.5 / np.sqrt(4**2 - 0.5**2)  # of the ball's outline
    assert abs(len(rows) - 2 * radius_px) < 4 and abs(len(columns) - 2 * radius_px) < 4
    inside = picture[110:130, 150:170].astype(int)
    assert np.ptp(inside[:, :, 0]) > 60  # the checks are still there


def test_a_surface_is_in_the_scene_with_what_was_completed_apart(run, made):
    from polhode_ground.judge.shape import load_ply
    from polhode_ground.reporting.scene import surfaces
    from polhode_ground.reporting.surface import write_surface
    (run / "surface.ply").write_bytes((made[0] / "model.ply").read_bytes())
    assert [one.name for one in surfaces(run)] == ["surface"]
    mesh = load_ply(made[0] / "model.ply")
    write_surface(run / "surface.ply", mesh.vertices, mesh.faces, np.arange(8) < 4)
    parts = surfaces(run)
    assert [one.name for one in parts] == ["surface, measured", "surface, completed"]
    assert len(parts[0].i) + len(parts[1].i) == 12 and all((np.array([one.i, one.j, one.k]) >= 4).all() for one in parts[:1])
    assert "surface, completed" in made_of(run) or "surface, completed" in (run / "report.html").read_text()


def test_a_video_that_cannot_be_made_is_refused(run, tmp_path):
    status, err = report(run, "--video", "/nonexistent/run.mp4")
    assert status == 2 and "--video /nonexistent/run.mp4" in err and err.count("\n") == 1
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps(summary | {"sequence": ""}))
    status, err = report(run, "--video", tmp_path / "run.mp4")
    assert status == 2 and "names no sequence" in err
