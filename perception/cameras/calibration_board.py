"""Calibration boards: a ChArUco board or a checkerboard, and its corners in an image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

MIN_SQUARES, MAX_SQUARES = 3, 50
"""Squares along one side of a board."""
MIN_SQUARE, MAX_SQUARE = 1e-3, 1.0
"""Range of the side of a square, m. A larger number is probably in mm. A smaller one was probably
in m where mm are expected."""
MIN_CORNERS = 6
"""Minimum number of corners in an image. Fewer leave the pose of the board poorly determined."""
SUBPIXEL_WINDOW = (5, 5)
"""Half size of the window in which corners are refined, px."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class CalibrationBoard:
    """A flat board. Its frame has x along the first side, y along the second, z into the board."""

    columns: int
    """Squares along x."""
    rows: int
    """Squares along y."""
    square: float
    """Side of a square, m."""
    marker: float | None
    """Side of a marker of a ChArUco board, m; None for a checkerboard."""
    dictionary: str = ""
    """Name of the markers' dictionary, such as ``5X5_100``."""

    @property
    def corners(self) -> NDArray[np.float64]:
        """Inner corners in the board's frame, (N, 3), m, row by row."""
        x, y = np.meshgrid(np.arange(1, self.columns), np.arange(1, self.rows))
        points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        return np.asarray(points * self.square, dtype=np.float64)

    def image(self, pixels_per_square: int, margin: int = 0) -> NDArray[np.uint8]:
        """Draw the board for a printer, (H, W) uint8, with a white margin in px."""
        if self.marker is not None:
            size = (self.columns * pixels_per_square, self.rows * pixels_per_square)
            drawn = np.asarray(_opencv_board(self).generateImage(size), dtype=np.uint8)
        else:
            x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
            dark = np.where((x + y) % 2 == 0, 0, 255).astype(np.uint8)
            drawn = np.kron(dark, np.ones((pixels_per_square, pixels_per_square), np.uint8))
        return np.pad(drawn, margin, constant_values=255)


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class BoardView:
    """The corners of a board in one image. It is false if too few were found."""

    pixels: NDArray[np.float64]
    """Positions in the image, (N, 2), px. Pixel centres have integer coordinates."""
    points: NDArray[np.float64]
    """The same corners in the board's frame, (N, 3), m."""

    def __bool__(self) -> bool:
        return len(self.pixels) >= MIN_CORNERS


def charuco_board(
    columns: int, rows: int, square: float, marker: float, dictionary: str = "5X5_100"
) -> CalibrationBoard:
    """Define a ChArUco board with the pattern of OpenCV 4.6 and later.

    Parameters
    ----------
    columns, rows
        Number of squares along x and y, as printed.
    square, marker
        Sides of a square and of a marker, m.
    dictionary
        Name of the markers' dictionary, as in ``cv2.aruco.DICT_<name>``.

    Raises
    ------
    InputError
        If a value is out of range, or the dictionary is unknown.
    """
    _check_size(columns, rows, square)
    if not 0.0 < marker < square:
        raise InputError(f"the marker must be smaller than the square {square} m, got {marker} m")
    name = dictionary.upper().removeprefix("DICT_")
    if not hasattr(cv2.aruco, f"DICT_{name}"):
        known = sorted(one.removeprefix("DICT_") for one in dir(cv2.aruco) if "DICT_" in one)
        raise InputError(f"unknown dictionary {dictionary!r}, expected one of {', '.join(known)}")
    board = CalibrationBoard(columns, rows, square, marker, name)
    needed, held = columns * rows // 2, len(_dictionary(name).bytesList)
    if needed > held:
        raise InputError(
            f"a board of {columns} x {rows} squares has {needed} markers, and the dictionary "
            f"{name} holds {held}: choose a larger one"
        )
    return board


def checkerboard(columns: int, rows: int, square: float) -> CalibrationBoard:
    """Define a checkerboard of `columns` x `rows` squares with sides of `square` m.

    Raises
    ------
    InputError
        If a value is out of range, or the board looks the same after a half turn.
    """
    _check_size(columns, rows, square)
    if (columns + rows) % 2 == 0:
        raise InputError(
            f"a checkerboard of {columns} x {rows} squares looks the same after a half turn: "
            "one side must have an even number of squares and the other an odd number"
        )
    return CalibrationBoard(columns, rows, square, None)


def detect_board(image: NDArray[np.uint8], board: CalibrationBoard) -> BoardView:
    """Detect the corners of a board in an image.

    Parameters
    ----------
    image
        (H, W) or (H, W, 3) uint8.
    board
        The board.

    Returns
    -------
    BoardView
        The corners; it is false if fewer than `MIN_CORNERS` were found.
    """
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    grey = np.ascontiguousarray(grey, dtype=np.uint8)
    pixels, numbers = _charuco(grey, board) if board.marker else _checkerboard(grey, board)
    return BoardView(pixels, board.corners[numbers])


def _check_size(columns: int, rows: int, square: float) -> None:
    if not (MIN_SQUARES <= columns <= MAX_SQUARES and MIN_SQUARES <= rows <= MAX_SQUARES):
        raise InputError(
            f"a board must have {MIN_SQUARES} to {MAX_SQUARES} squares along each side, "
            f"got {columns} x {rows}"
        )
    if not MIN_SQUARE <= square <= MAX_SQUARE:
        raise InputError(
            f"the square must be {MIN_SQUARE} to {MAX_SQUARE} m, got {square:g} m: --square is in "
            "mm, Python's boards in m"
        )


def _opencv_board(board: CalibrationBoard) -> Any:
    size, markers = (board.columns, board.rows), _dictionary(board.dictionary)
    return cv2.aruco.CharucoBoard(size, board.square, board.marker or 0.0, markers)


def _dictionary(name: str) -> Any:
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))


def _charuco(
    grey: NDArray[np.uint8], board: CalibrationBoard
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return pixels (N, 2) and numbers (N,) of the corners between markers that were read."""
    detector = cv2.aruco.CharucoDetector(_opencv_board(board))
    corners, numbers, _, _ = detector.detectBoard(grey)
    if corners is None or numbers is None or len(corners) == 0:
        return np.empty((0, 2)), np.empty(0, np.intp)
    pixels = _refine(grey, np.asarray(corners, np.float32).reshape(-1, 1, 2))
    return pixels, np.asarray(numbers).reshape(-1).astype(np.intp)


def _checkerboard(
    grey: NDArray[np.uint8], board: CalibrationBoard
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return pixels (N, 2) and numbers (N,) of all corners, or none if one is hidden."""
    size = (board.columns - 1, board.rows - 1)
    found, corners = cv2.findChessboardCornersSB(grey, size, flags=cv2.CALIB_CB_ACCURACY)
    if not found:
        return np.empty((0, 2)), np.empty(0, np.intp)
    pixels = np.asarray(corners, np.float64).reshape(-1, 2)
    if not _starts_at_dark_square(grey, pixels.reshape(size[1], size[0], 2)):
        pixels = pixels[::-1]
    return np.ascontiguousarray(pixels), np.arange(len(pixels))


def _starts_at_dark_square(grey: NDArray[np.uint8], grid: NDArray[np.float64]) -> bool:
    """Report whether the square before the first corner is dark, as on the board.

    The other end of a board with an even and an odd side has a bright square there.
    """
    outer = grid[0, 0] - 0.5 * (grid[0, 1] - grid[0, 0]) - 0.5 * (grid[1, 0] - grid[0, 0])
    beside = grid[0, 0] - 0.5 * (grid[0, 1] - grid[0, 0]) + 0.5 * (grid[1, 0] - grid[0, 0])
    column, row = np.clip(np.rint(outer), 0, [grey.shape[1] - 1, grey.shape[0] - 1]).astype(int)
    other = np.clip(np.rint(beside), 0, [grey.shape[1] - 1, grey.shape[0] - 1]).astype(int)
    return bool(grey[row, column] < grey[other[1], other[0]])


def _refine(grey: NDArray[np.uint8], corners: NDArray[np.float32]) -> NDArray[np.float64]:
    """Refine corners (N, 1, 2) where the squares cross, px."""
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    refined = cv2.cornerSubPix(grey, corners, SUBPIXEL_WINDOW, (-1, -1), stop)
    return np.asarray(refined, np.float64).reshape(-1, 2)
