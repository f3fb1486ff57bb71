"""Pictures of a video as a player shows them: one field, upright, not mirrored."""

import numpy as np

from polhode_ground.importing.source import Account


def first_field(pixels: np.ndarray) -> np.ndarray:
    """Every second line between those of the first field is the mean of its neighbours."""
    whole = pixels.copy()
    above, below = pixels[0:-1:2][: len(pixels[1::2])], pixels[2::2]
    whole[1 : 1 + 2 * len(below) : 2] = (above[: len(below)].astype(np.uint32) + below + 1) // 2
    whole[1 + 2 * len(below) :: 2] = above[len(below) :]
    return whole


def aspect_of(stream, rotation_deg: int) -> float:
    """Width by height of a pixel as it is shown, after the rotation; 1 where the container does not tell it."""
    aspect = float(stream.sample_aspect_ratio or 1)
    return 1 / aspect if round(rotation_deg / 90) % 2 else aspect


def upright(pixels: np.ndarray, rotation_deg: int, account: Account) -> np.ndarray:
    """Turned as a player shows it. @param rotation_deg  FFmpeg's: anticlockwise, in -180 .. 180"""
    quarters = round(rotation_deg / 90) % 4
    if abs(rotation_deg / 90 - round(rotation_deg / 90)) > 0.01:
        account.note(
            f"the video's display matrix turns by {rotation_deg:g} deg: only quarters are undone, the pictures stay as they are stored"
        )
        return pixels
    if quarters:
        account.note(
            f"turned by {90 * quarters} deg anticlockwise, as the video's rotation flag says, and the intrinsics taken to be of turned pictures"
        )
    return np.ascontiguousarray(np.rot90(pixels, quarters))


def mirrored(pixels: np.ndarray, frame, account: Account) -> np.ndarray:
    """As a player shows it: a display matrix of negative determinant mirrors. FFmpeg's rotation leaves that out."""
    data = frame.side_data.get("DISPLAYMATRIX")
    if data is None:
        return pixels
    matrix = np.frombuffer(bytes(data), np.int32).astype(float)
    if matrix[0] * matrix[4] - matrix[1] * matrix[3] >= 0:
        return pixels
    account.note("mirrored, as the video's display matrix says; where writing is reversed in the sequence, that is wrong")
    return np.ascontiguousarray(np.flip(pixels, 0 if abs(matrix[0]) > abs(matrix[1]) else 1))
