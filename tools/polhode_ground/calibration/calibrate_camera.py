"""Calibrates a camera from pictures or a video of a chessboard or ChArUco board.

Twenty pictures with the board tilted by 30 to 45 deg in all directions and in all corners of the picture are good, five different
ones the least. A video counts as 40 pictures, spread over it. Move slowly: a rolling shutter bends what moves. EXIF orientation
is passed over, as a replay does: pixels are taken as they are stored.
Writes sensor.yaml (ASL layout, as `polhode replay` reads it), beside it a picture of the residuals, and prints the same values
as a [camera] section for `polhode run`. Status 1: the pictures do not determine the camera; 2: unusable arguments.

Examples:
  tools/calibrate_camera.py --board chessboard --squares 10x7 --square-m 0.03 --out sensor.yaml PICTURE...
  tools/calibrate_camera.py --board charuco --squares 10x7 --square-m 0.03 --marker-m 0.022 --out sensor.yaml board.mp4
"""

import argparse
import pathlib
import sys

from polhode_ground.common.venv import enter_venv, run_main

VIDEO_FRAMES = 40  # of a video: more views hardly tell more, and each is searched for the board
SENSOR = """\
# From {views} pictures, RMS residual {rms:.3f} px. 1 sigma: fu {sfu:.2f}, fv {sfv:.2f}, cu {scu:.2f}, cv {scv:.2f} px
sensor_type: camera
rate_hz: {rate}
resolution: [{width}, {height}]
camera_model: pinhole
intrinsics: [{fu:.6f}, {fv:.6f}, {cu:.6f}, {cv:.6f}]  # fu, fv, cu, cv [px]; the centre of the top-left pixel is (0, 0)
distortion_model: radial-tangential
distortion_coefficients: [{k1:.8f}, {k2:.8f}, {p1:.8f}, {p2:.8f}]
"""

SECTION = """\
[camera]
width_px = {width}
height_px = {height}
fu_px = {fu:.6f}
fv_px = {fv:.6f}
cu_px = {cu:.6f}
cv_px = {cv:.6f}
k1 = {k1:.8f}
k2 = {k2:.8f}
p1 = {p1:.8f}
p2 = {p2:.8f}
"""


def values(calibration, rate_hz: float) -> dict:
    named = dict(zip(("fu", "fv", "cu", "cv"), calibration.intrinsics))
    named |= dict(zip(("sfu", "sfv", "scu", "scv"), calibration.sigma_intrinsics))
    named |= dict(zip(("k1", "k2", "p1", "p2"), calibration.distortion))
    return named | {
        "width": calibration.width_px,
        "height": calibration.height_px,
        "rate": rate_hz,
        "rms": calibration.rms_px,
        "views": len(calibration.views),
    }


def squares(text: str) -> tuple[int, int]:
    columns, rows = (int(part) for part in text.lower().split("x"))
    if min(columns, rows) < 3:
        raise ValueError
    return columns, rows


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.strip(), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="+", type=pathlib.Path, metavar="PICTURE")
    parser.add_argument("--board", choices=("chessboard", "charuco"), required=True)
    parser.add_argument("--squares", type=squares, required=True, help="columns x rows of squares, as in 10x7")
    parser.add_argument("--square-m", type=float, required=True, help="edge of a square, metres")
    parser.add_argument("--marker-m", type=float, default=0.0, help="edge of a marker, metres (charuco)")
    parser.add_argument("--dictionary", default="DICT_5X5_100", help="of the markers (charuco)")
    parser.add_argument("--legacy", action="store_true", help="a board that was drawn by OpenCV before 4.6 (charuco with even rows)")
    parser.add_argument("--rate-hz", type=float, default=10.0, help="written into sensor.yaml")
    parser.add_argument("--out", type=pathlib.Path, required=True, metavar="sensor.yaml")
    parsed = parser.parse_args()
    if parsed.square_m <= 0 or (parsed.board == "charuco" and not 0 < parsed.marker_m < parsed.square_m):
        parser.error("--square-m must be positive, --marker-m between 0 and it")
    return parsed


def picture_of(file: pathlib.Path):
    """Gray as it is stored; None where it is no picture."""
    import cv2

    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.decoding import read_picture

    gray = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION)
    if gray is not None:
        return gray
    try:
        return read_picture(file).pixels
    except BadInput:
        return None


def pictures_of(files: list[pathlib.Path]):
    """(name, gray [H,W] of 8 bits) of each picture; of a video one frame in each part of it, as many parts as VIDEO_FRAMES."""
    from polhode_ground.calibration.boards import eight_bits
    from polhode_ground.calibration.solve import NotCalibrated
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.source import Options
    from polhode_ground.importing.video import open_video

    for file in files:
        gray = picture_of(file)
        if gray is not None:
            yield file.name, eight_bits(gray)
            continue
        try:
            count = sum(1 for _ in open_video(file, Options()).frames)  # containers do not always tell it
            step = max(1, count // VIDEO_FRAMES)
            for number, frame in enumerate(open_video(file, Options()).frames):
                if number % step == 0:
                    yield f"{file.name}, frame {number}", eight_bits(frame.pixels)
        except BadInput:
            raise NotCalibrated(f"{file}: not a picture, nor a video") from None


def find_views(files: list[pathlib.Path], board) -> tuple[list, tuple[int, int]]:
    from polhode_ground.calibration import diagnose
    from polhode_ground.calibration.boards import find_view
    from polhode_ground.calibration.solve import NotCalibrated

    views, size, without = [], None, []
    looked_at = 0
    for name, gray in pictures_of(files):
        looked_at += 1
        size = size or gray.shape[::-1]
        if gray.shape[::-1] != size:
            raise NotCalibrated(f"{name}: {gray.shape[1]}x{gray.shape[0]}, but the pictures before it are {size[0]}x{size[1]}")
        view = find_view(name, gray, board)
        print(f"{name}: {f'{len(view.image_px)} corners' if view else 'board not found'}")
        if view is not None:
            views.append(view)
        elif len(without) < diagnose.PICTURES:
            without.append(gray)
    if not views:
        raise NotCalibrated(f"the board was found in none of {looked_at} pictures: {diagnose.explain(without, board)}")
    return views, size


def main() -> int:
    asked = parse()
    import cv2

    from polhode_ground.calibration import pictures
    from polhode_ground.calibration.boards import Board
    from polhode_ground.calibration.solve import NotCalibrated, calibrate, warnings
    from polhode_ground.common.errors import BadInput
    from polhode_ground.common.whole_file import MARK, beside, check_replaceable, write_whole

    plot = asked.out.with_suffix(".png")
    if plot == asked.out:
        raise BadInput(f"--out {asked.out}: the residuals' picture has this name; allowed is another suffix, as in sensor.yaml")
    for file in (asked.out, plot):
        check_replaceable(file)
    cv2.setNumThreads(1)  # sums in another order differ in the last digits: the same pictures give the same file
    if not hasattr(cv2.aruco, asked.dictionary):
        raise BadInput(f"--dictionary {asked.dictionary}: unknown")
    board = Board(asked.board, *asked.squares, asked.square_m, asked.marker_m, asked.dictionary, asked.legacy)
    try:
        views, (width_px, height_px) = find_views(asked.pictures, board)
        calibration = calibrate(views, width_px, height_px)
    except NotCalibrated as problem:
        print(f"calibrate_camera: {problem}", file=sys.stderr)
        return 1
    named = values(calibration, asked.rate_hz)
    write_whole(asked.out, f"{SENSOR.format(**named)}# {MARK}\n")
    with beside(plot) as part:
        pictures.draw(calibration, part)
    print(SECTION.format(**named))
    for name in calibration.left_out:
        print(f"left out, does not fit the others: {name}")
    for warning in warnings(calibration):
        print(f"warning: {warning}")
    print(f"RMS residual {calibration.rms_px:.3f} px; written {asked.out} and {plot}")
    return 0


def command() -> None:
    enter_venv()
    run_main(main, "calibrate_camera")
