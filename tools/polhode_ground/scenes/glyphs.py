"""A 5 x 7 letter set for decals."""

import numpy as np

# Seven rows of five bits per letter, top row first.
_ROWS = {
    "A": "0E11111F111111",
    "C": "0E11101010110E",
    "D": "1E11111111111E",
    "E": "1F10101E10101F",
    "F": "1F10101E101010",
    "G": "0E11101713110F",
    "H": "1111111F111111",
    "I": "0E04040404040E",
    "K": "11121418141211",
    "L": "1010101010101F",
    "M": "111B1515111111",
    "N": "11191513111111",
    "O": "0E11111111110E",
    "P": "1E11111E101010",
    "R": "1E11111E141211",
    "S": "0F10100E01011E",
    "T": "1F040404040404",
    "U": "1111111111110E",
    "V": "11111111110A04",
    "W": "11111115151B11",
    "J": "0702020202120C",
    "Q": "0E11111115120D",
    "B": "1E11111E11111E",
    "X": "11110A040A1111",
    "Y": "11110A04040404",
    "Z": "1F01020408101F",
    "0": "0E11131519110E",
    "1": "040C040404040E",
    "2": "0E11010608101F",
    "3": "1F02040201110E",
    "4": "02060A121F0202",
    "5": "1F101E0101110E",
    "6": "0608101E11110E",
    "7": "1F010204080808",
    "8": "0E11110E11110E",
    "9": "0E11110F01020C",
    "-": "0000001F000000",
    " ": "00000000000000",
    "/": "01010204081010",
}


def text_mask(text, size_px):
    """Mask (7 * size, 6 * size * len) of a line of text, row 0 at the bottom."""
    rows = np.zeros((7, 6 * len(text)), dtype=np.float32)
    for n, letter in enumerate(text):
        for r in range(7):
            bits = int(_ROWS[letter][2 * r : 2 * r + 2], 16)
            for c in range(5):
                rows[6 - r, 6 * n + c] = (bits >> (4 - c)) & 1
    return np.kron(rows, np.ones((size_px, size_px), dtype=np.float32))
