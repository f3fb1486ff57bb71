"""Calibration boards, and their corners in pictures."""

import dataclasses

import cv2
import numpy


@dataclasses.dataclass
class Board:
    """columns x rows squares of `square_m`. A chessboard has its corners between squares; a ChArUco board has a marker of
    `marker_m` in each white square, so that a part of it is enough."""

    kind: str
    columns: int
    rows: int
    square_m: float
    marker_m: float = 0.0
    dictionary: str = "DICT_5X5_100"
    legacy: bool = False  # drawn before OpenCV 4.6: with even rows its first square is white

    def charuco(self) -> "cv2.aruco.CharucoBoard":
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        board = cv2.aruco.CharucoBoard((self.columns, self.rows), self.square_m, self.marker_m, dictionary)
        board.setLegacyPattern(self.legacy)
        return board

    def corners_m(self) -> numpy.ndarray:
        """All inner corners on the board, N x 3 [m], row by row."""
        u, v = numpy.meshgrid(numpy.arange(1, self.columns), numpy.arange(1, self.rows))
        return numpy.stack([u.ravel() * self.square_m, v.ravel() * self.square_m, numpy.zeros(u.size)], axis=1)


@dataclasses.dataclass
class View:
    """One picture's corners: on the board [m] and in the picture [px], N x 3 and N x 2."""

    name: str
    board_m: numpy.ndarray
    image_px: numpy.ndarray


CORNERS_MIN = 8  # fewer hardly tell a pose


def find_chessboard(gray: numpy.ndarray, board: Board) -> tuple[numpy.ndarray, numpy.ndarray] | None:
    size = (board.columns - 1, board.rows - 1)
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    found, corners = cv2.findChessboardCornersSB(gray, size, flags=flags)
    if not found:
        return None
    # Refined where the gradients of the edges meet: three times as exact as where it was found. The window must not
    # reach the next corner.
    spacing_px = numpy.min(numpy.linalg.norm(numpy.diff(corners.reshape(size[1], size[0], 2), axis=1), axis=2))
    half = int(numpy.clip(spacing_px / 4, 2, 11))
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
    refined = cv2.cornerSubPix(gray, corners.astype(numpy.float32), (half, half), (-1, -1), stop)
    return board.corners_m(), refined.reshape(-1, 2)


def find_charuco(gray: numpy.ndarray, board: Board) -> tuple[numpy.ndarray, numpy.ndarray] | None:
    corners, ids, _, _ = cv2.aruco.CharucoDetector(board.charuco()).detectBoard(gray)
    if ids is None or len(ids) < CORNERS_MIN:
        return None
    return board.corners_m()[numpy.asarray(ids).ravel()], numpy.asarray(corners).reshape(-1, 2)


def eight_bits(gray: numpy.ndarray) -> numpy.ndarray:
    """Levels of any other number type from 0 to the picture's largest, as 0 to 255."""
    if gray.dtype == numpy.uint8:
        return gray
    levels = numpy.nan_to_num(gray.astype(float), posinf=0.0, neginf=0.0).clip(min=0.0)
    return numpy.rint(levels * (255.0 / max(levels.max(initial=0.0), 1e-30))).astype(numpy.uint8)


def find_view(name: str, gray: numpy.ndarray, board: Board) -> View | None:
    """The board in an 8-bit picture, or None."""
    found = find_chessboard(gray, board) if board.kind == "chessboard" else find_charuco(gray, board)
    return None if found is None else View(name, found[0].astype(float), found[1].astype(float))
