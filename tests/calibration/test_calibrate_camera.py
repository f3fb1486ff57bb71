"""The calibration finds the camera that the pictures were rendered with."""

import pathlib
import subprocess
import sys

import cv2
import numpy
import pytest
import rendered_boards as rendered
from polhode_ground.calibration.boards import Board

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


COLUMNS, ROWS, SQUARE_M = 10, 7, 0.03
TOOL = [sys.executable, REPOSITORY / "tools/calibrate_camera.py", "--squares", f"{COLUMNS}x{ROWS}", "--square-m", str(SQUARE_M)]


def take_pictures(folder: pathlib.Path, kind: str, count: int = 9) -> list[pathlib.Path]:
    random = numpy.random.default_rng(4)
    if kind == "chessboard":
        level = rendered.chessboard(COLUMNS, ROWS)
    else:
        level = rendered.printed(Board("charuco", COLUMNS, ROWS, SQUARE_M, 0.022), COLUMNS, ROWS)
    files = []
    for i, (R, t) in enumerate(rendered.poses(COLUMNS, ROWS, SQUARE_M, count, random)):
        files.append(folder / f"picture{i}.png")
        cv2.imwrite(str(files[-1]), rendered.seen(level, SQUARE_M, R, t, random))
    return files


def run(*arguments):
    return subprocess.run([*map(str, TOOL), *map(str, arguments)], capture_output=True, text=True)


def read_sensor(file: pathlib.Path) -> tuple[numpy.ndarray, numpy.ndarray]:
    fields = dict(line.split(":", 1) for line in file.read_text().splitlines() if ":" in line and not line.startswith("#"))
    numbers = {key: numpy.array([float(x) for x in fields[key].split("#")[0].strip(" []").split(",")])
               for key in ("intrinsics", "distortion_coefficients")}
    return numbers["intrinsics"], numbers["distortion_coefficients"]


def pixel_error(intrinsics: numpy.ndarray, distortion: numpy.ndarray) -> float:
    """Worst distance [px] between where the found and the true camera see the same directions, over the whole picture."""
    v, u = numpy.mgrid[0:rendered.HEIGHT:20, 0:rendered.WIDTH:20].astype(float)
    rays = rendered.rays_of(u.ravel(), v.ravel())
    fu, fv, cu, cv = intrinsics
    matrix = numpy.array([[fu, 0, cu], [0, fv, cv], [0, 0, 1]])
    seen, _ = cv2.projectPoints(rays, numpy.zeros(3), numpy.zeros(3), matrix, distortion)
    return float(numpy.max(numpy.linalg.norm(seen.reshape(-1, 2) - numpy.stack([u.ravel(), v.ravel()], axis=1), axis=1)))


# verifies: GND-04
@pytest.mark.parametrize("kind", ["chessboard", pytest.param("charuco", marks=pytest.mark.further)])
def test_finds_the_camera_that_took_the_pictures(tmp_path, kind):
    files = take_pictures(tmp_path, kind)
    extra = ["--marker-m", "0.022"] if kind == "charuco" else []
    done = run("--board", kind, *extra, "--out", tmp_path / "sensor.yaml", *files)
    assert done.returncode == 0, done.stderr
    intrinsics, distortion = read_sensor(tmp_path / "sensor.yaml")
    # Corners are found to 0.05 to 0.1 px; 450 of them leave the focal length to some 1e-3 and the principal point to 1 px.
    assert intrinsics[:2] == pytest.approx(rendered.INTRINSICS[:2], rel=3e-3)
    assert intrinsics[2:] == pytest.approx(rendered.INTRINSICS[2:], abs=1.5)
    assert distortion[0] == pytest.approx(rendered.DISTORTION[0], abs=0.02)
    # A shift of the principal point with a turn of the camera is not seen on a board, so some px remain at the picture's edges.
    assert pixel_error(intrinsics, distortion) < 3.0
    words = (tmp_path / "sensor.yaml").read_text().splitlines()[0].replace(",", "").split()
    sigma = numpy.array([float(words[words.index(name) + 1]) for name in ("fu", "fv", "cu", "cv")])
    assert (abs(intrinsics - rendered.INTRINSICS) < 4.0 * sigma).all(), (intrinsics, sigma)
    assert (tmp_path / "sensor.png").stat().st_size > 10_000
    assert "[camera]" in done.stdout


def test_leaves_a_picture_out_that_does_not_fit(tmp_path):
    files = take_pictures(tmp_path, "chessboard", 7)
    good = cv2.imread(str(files[2]), cv2.IMREAD_GRAYSCALE)
    wave = numpy.arange(rendered.WIDTH) + 6.0 * numpy.sin(numpy.arange(rendered.WIDTH) / 40.0)
    u, v = numpy.meshgrid(wave.astype(numpy.float32), numpy.arange(rendered.HEIGHT, dtype=numpy.float32))
    cv2.imwrite(str(files[2]), cv2.remap(good, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
    done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", *files)
    assert done.returncode == 0, done.stderr
    assert "left out, does not fit the others" in done.stdout and "picture2.png" in done.stdout.split("left out", 1)[1]
    intrinsics, _ = read_sensor(tmp_path / "sensor.yaml")
    assert intrinsics[:2] == pytest.approx(rendered.INTRINSICS[:2], rel=5e-3)


# verifies: GND-04
def test_too_few_boards_are_no_calibration(tmp_path):
    files = take_pictures(tmp_path, "chessboard", 2)
    cv2.imwrite(str(tmp_path / "empty.png"), numpy.full((rendered.HEIGHT, rendered.WIDTH), 90, numpy.uint8))
    done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", *files, tmp_path / "empty.png")
    assert done.returncode == 1
    assert "found in 2 pictures" in done.stderr
    assert not (tmp_path / "sensor.yaml").exists()


def test_pictures_of_different_sizes_are_refused(tmp_path):
    for name, side in (("a.png", 100), ("b.png", 120)):
        cv2.imwrite(str(tmp_path / name), numpy.zeros((side, side), numpy.uint8))
    done = run("--board", "chessboard", "--out", tmp_path / "s.yaml", tmp_path / "a.png", tmp_path / "b.png")
    assert done.returncode == 1 and "120x120" in done.stderr


@pytest.mark.parametrize("arguments", [["--board", "charuco", "--out", "s.yaml", "x.png"],
                                       ["--board", "chessboard", "--squares", "2x9", "--out", "s.yaml", "x.png"],
                                       ["--board", "circles", "--out", "s.yaml", "x.png"]])
def test_unusable_arguments(arguments):
    assert run(*arguments).returncode == 2


@pytest.mark.further
def test_a_video_of_the_board_does_as_well(tmp_path):
    """Each picture for two frames: of 18 frames all are looked at, and the codec moves corners by little."""
    from made_sources import write_video
    files = take_pictures(tmp_path, "chessboard")
    frames = [cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in files for _ in range(2)]
    write_video(tmp_path / "board.mp4", frames, [i / 10 for i in range(len(frames))])
    done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", tmp_path / "board.mp4")
    assert done.returncode == 0, done.stderr
    assert "board.mp4, frame 4:" in done.stdout
    assert pixel_error(*read_sensor(tmp_path / "sensor.yaml")) < 3.0  # as for the pictures themselves


def test_what_is_neither_picture_nor_video_is_named(tmp_path):
    (tmp_path / "notes.txt").write_text("no picture")
    done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", tmp_path / "notes.txt")
    assert done.returncode == 1 and "notes.txt: not a picture, nor a video" in done.stderr and done.stderr.count("\n") == 1


def show(folder: pathlib.Path, level, poses) -> list[pathlib.Path]:
    random, files = numpy.random.default_rng(5), []
    for i, (R, t) in enumerate(poses):
        files.append(folder / f"view{i}.png")
        cv2.imwrite(str(files[-1]), rendered.seen(level, SQUARE_M, R, t, random, samples=1))
    return files


def test_views_face_on_are_refused_with_what_is_missing(tmp_path):
    middle = numpy.array([COLUMNS, ROWS, 0.0]) * SQUARE_M / 2
    poses = [(numpy.eye(3), numpy.array([0.04 * (i % 3 - 1), 0.03 * (i // 3 - 1), 0.6]) - middle) for i in range(6)]
    done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", *show(tmp_path, rendered.chessboard(COLUMNS, ROWS), poses))
    assert done.returncode == 1 and "missing are tilts" in done.stderr and not (tmp_path / "sensor.yaml").exists()


def test_one_view_many_times_is_one(tmp_path):
    files = take_pictures(tmp_path, "chessboard", 4)
    done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", *files, *files)
    assert done.returncode == 1 and "8 pictures, 4 of them from where another was taken; at least 5" in done.stderr


@pytest.mark.further
def test_orientation_tags_change_nothing(tmp_path):
    from PIL import Image

    got, pictures = [], take_pictures(tmp_path, "chessboard", 5)
    for orientation in (1, 6):
        files = []
        for file in pictures:
            tag = Image.Exif()
            tag[0x0112] = orientation
            files.append(file.with_suffix(f".{orientation}.jpg"))
            Image.open(file).save(files[-1], quality=95, exif=tag)
        done = run("--board", "chessboard", "--out", tmp_path / "sensor.yaml", *files)
        assert done.returncode == 0, done.stderr
        got.append((tmp_path / "sensor.yaml").read_text())
    assert got[0] == got[1]


@pytest.mark.parametrize(("drawn", "told", "says"), [
    (dict(columns=7, rows=10, legacy=True), ["--squares", "7x10"], "it is found with --legacy"),
    (dict(columns=10, rows=7), ["--squares", "7x10"], "it is found with --squares 10x7"),
    (dict(columns=10, rows=7), ["--dictionary", "DICT_4X4_50"], "--dictionary DICT_5X5"),
    (None, ["--squares", "9x6"], "it is found with --squares 10x7"),
])
def test_a_board_that_is_not_found_says_what_would_fit(tmp_path, drawn, told, says):
    columns, rows = (drawn["columns"], drawn["rows"]) if drawn else (COLUMNS, ROWS)
    level = rendered.printed(Board("charuco", square_m=SQUARE_M, marker_m=0.022, **drawn), columns, rows) if drawn else rendered.chessboard(columns, rows)
    files = show(tmp_path, level, list(rendered.poses(columns, rows, SQUARE_M, 2, numpy.random.default_rng(4))))
    kind = ["--board", "charuco", "--marker-m", "0.022"] if drawn else ["--board", "chessboard"]
    done = run(*kind, *told, "--out", tmp_path / "sensor.yaml", *files)
    assert done.returncode == 1 and says in done.stderr, done.stderr
    assert (not drawn) or "markers were seen" in done.stderr
