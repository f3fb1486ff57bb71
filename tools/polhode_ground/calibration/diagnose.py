"""Why a board was found in no picture: what was seen of it, and which arguments would fit."""

import dataclasses

import cv2
import numpy

from .boards import Board, find_view

PICTURES = 3  # that are looked at: each takes a search for every dictionary


def markers(gray: numpy.ndarray, dictionary: str) -> list[int]:
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary)))
    _, ids, _ = detector.detectMarkers(gray)
    return [] if ids is None else [int(number) for number in numpy.ravel(ids)]


def fits(pictures: list[numpy.ndarray], boards: list[tuple[str, Board]]) -> str | None:
    """The first of these boards that is found in a picture."""
    return next((name for name, board in boards for gray in pictures if find_view("", gray, board)), None)


def charuco(pictures: list[numpy.ndarray], board: Board) -> list[str]:
    expected = board.columns * board.rows // 2
    seen = [markers(gray, board.dictionary) for gray in pictures]
    most = max(seen, key=len)
    told = [f"{len(most)} of the board's {expected} markers were seen ({board.dictionary})"]
    if most and max(most) >= expected:
        told.append(f"one has the number {max(most)}, so the board is larger than {board.columns}x{board.rows}")
    if len(most) < expected / 2:
        others = {
            name: max(len(markers(gray, name)) for gray in pictures)
            for name in dir(cv2.aruco)
            if name.startswith("DICT_") and "APRILTAG" not in name and name != board.dictionary
        }
        best = max(others, key=lambda name: (others[name], -len(name)))
        if others[best] > 2 * len(most) + 3:
            told.append(f"{others[best]} markers are of {best}: --dictionary {best}")
            board = dataclasses.replace(board, dictionary=best)
    swapped = dataclasses.replace(board, columns=board.rows, rows=board.columns)
    legacy = {"legacy": not board.legacy}
    found = fits(
        pictures,
        [
            ("", board),
            ("--legacy" if not board.legacy else "without --legacy", dataclasses.replace(board, **legacy)),
            (f"--squares {swapped.columns}x{swapped.rows}", swapped),
            (f"--squares {swapped.columns}x{swapped.rows} --legacy", dataclasses.replace(swapped, **legacy)),
        ],
    )
    return told + ([f"it is found with {found}"] if found else [])


def chessboard(pictures: list[numpy.ndarray], board: Board) -> list[str]:
    sizes = [
        (board.columns + 1, board.rows + 1),
        (board.columns - 1, board.rows - 1),
        (board.rows, board.columns),
        (board.rows + 1, board.columns + 1),
    ]
    boards = [
        (f"--squares {columns}x{rows}", dataclasses.replace(board, columns=columns, rows=rows))
        for columns, rows in sizes
        if min(columns, rows) >= 3
    ]
    found = fits(pictures, boards)
    return (
        [f"it is found with {found} (squares are counted, not inner corners)"]
        if found
        else ["nor with one row and column more or less; is all of the board in the picture, with a white margin?"]
    )


def explain(pictures: list[numpy.ndarray], board: Board) -> str:
    looked_at = pictures[:PICTURES]
    return "; ".join(charuco(looked_at, board) if board.kind == "charuco" else chessboard(looked_at, board))
