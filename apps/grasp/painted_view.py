"""Draw points, solids and boxes in one 3D view with OpenCV: far pieces first.

OpenGL would need a graphics driver. Large faces are cut into tiles so that their order is right.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from .jaw_shapes import EDGES, FACES

FINER = 2
"""Enlargement at which the view is drawn. Its reduction smooths edges."""
TILE = 0.012
"""Maximum side of a tile of a face, m."""
DARKEST = 0.55
"""Brightness of a face at a right angle to the viewer, relative to one that faces the viewer."""
POINT_RADIUS = 0.0012
"""Radius of a point, m."""
LIFT = 0.002
"""Distance by which edges are drawn nearer than the faces beside them, m."""
SUBPIXEL = 4
"""Bits of the fraction of a pixel in OpenCV's coordinates."""

Colour = tuple[int, int, int]


@dataclass
class PaintedView:
    """An orthographic view onto which pieces are painted in the order of their depth."""

    axes: NDArray[np.float64]
    """Right, up and towards the viewer: the rows of a rotation (3, 3)."""
    middle: NDArray[np.float64]
    """Point (3,) in the middle of the picture, m."""
    half: float
    """Half of the picture's width, m."""
    shape: tuple[int, int]
    """Height and width of the picture, px."""
    _pieces: list[tuple[float, NDArray[np.int32], Colour, int]] = field(default_factory=list)

    def add_points(self, points: NDArray[np.float64], colours: NDArray[np.uint8]) -> None:
        """Add points (N, 3) with their colours (N, 3)."""
        local = self._local(points)
        pixels = self._pixels(local)
        radius = max(round(POINT_RADIUS / self.half * self.shape[1] * FINER / 2), 1)
        for depth, pixel, colour in zip(
            local[:, 2].tolist(), pixels, colours.tolist(), strict=True
        ):
            self._pieces.append((depth, pixel[None], colour, -radius))

    def add_mesh(
        self, vertices: NDArray[np.float64], faces: NDArray[np.int64], colour: Colour
    ) -> None:
        """Add the triangles (T, 3) of a closed mesh (V, 3) that face the viewer."""
        self._add_faces(vertices[faces], colour)

    def add_box(self, corners: NDArray[np.float64], colour: Colour) -> None:
        """Add a box with its corners (8, 3) in the order of `jaw_shapes.CORNERS`."""
        for face in FACES:
            a, b, _, d = corners[list(face)]
            across, along = b - a, d - a
            n = max(int(np.ceil(np.linalg.norm(across) / TILE)), 1)
            m = max(int(np.ceil(np.linalg.norm(along) / TILE)), 1)
            i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(m)))
            square = [
                a + (i + di)[:, None] / n * across + (j + dj)[:, None] / m * along
                for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            self._add_faces(np.stack(square, axis=1), colour)
        self.add_wire(corners, _darker(colour), 1)

    def add_wire(self, corners: NDArray[np.float64], colour: Colour, width: int) -> None:
        """Add the edges of a box with its corners (8, 3)."""
        for start, end in EDGES:
            self.add_line(corners[[start, end]], colour, width)

    def add_line(self, line: NDArray[np.float64], colour: Colour, width: int) -> None:
        """Add a line (K, 3) of a width in px."""
        for start, end in itertools.pairwise(line):
            n = max(int(np.ceil(np.linalg.norm(end - start) / TILE)), 1)
            local = self._local(start + np.linspace(0, 1, n + 1)[:, None] * (end - start))
            pixels = self._pixels(local)
            for k in range(n):
                depth = float(local[k : k + 2, 2].mean()) + LIFT
                self._pieces.append((depth, pixels[k : k + 2], colour, width * FINER))

    def pixel_of(self, point: NDArray[np.float64]) -> tuple[int, int]:
        """Return the pixel (x, y) of a point (3,) in the finished picture."""
        x, y = self._pixels(self._local(point[None]))[0] / (FINER << SUBPIXEL)
        return int(x), int(y)

    def painted(self, background: Colour) -> NDArray[np.uint8]:
        """Return the picture (height, width, 3) uint8 RGB."""
        canvas = np.empty((self.shape[0] * FINER, self.shape[1] * FINER, 3), np.uint8)
        canvas[:] = background
        for _, pixels, colour, width in sorted(self._pieces, key=lambda piece: piece[0]):
            if width == 0:
                cv2.fillConvexPoly(canvas, pixels, colour, cv2.LINE_8, SUBPIXEL)
            elif width < 0:
                x, y = pixels[0] >> SUBPIXEL
                cv2.circle(canvas, (int(x), int(y)), -width, colour, cv2.FILLED)
            else:
                cv2.polylines(canvas, [pixels], False, colour, width, cv2.LINE_8, SUBPIXEL)
        size = (self.shape[1], self.shape[0])
        return np.asarray(cv2.resize(canvas, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)

    def _add_faces(self, polygons: NDArray[np.float64], colour: Colour) -> None:
        """Add polygons (T, K, 3), counter-clockwise from outside, that face the viewer."""
        local = self._local(polygons)
        normals = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
        lengths = np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
        bright = normals[:, 2] / lengths
        for k in np.flatnonzero(bright > 0):
            shade = DARKEST + (1.0 - DARKEST) * bright[k]
            r, g, b = (round(shade * part) for part in colour)
            pixels = self._pixels(local[k])
            self._pieces.append((float(local[k, :, 2].mean()), pixels, (r, g, b), 0))

    def _local(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return (points - self.middle) @ self.axes.T

    def _pixels(self, local: NDArray[np.float64]) -> NDArray[np.int32]:
        """Return fixed-point pixels (..., 2) of local points (..., 3)."""
        scale = FINER * self.shape[1] / (2.0 * self.half)
        centre = 0.5 * FINER * np.array([self.shape[1], self.shape[0]])
        pixels = centre + scale * local[..., :2] * [1.0, -1.0]
        limit = 4.0 * FINER * max(self.shape)
        return np.round(np.clip(pixels, -limit, limit) * (1 << SUBPIXEL)).astype(np.int32)


def _darker(colour: Colour) -> Colour:
    r, g, b = (round(0.45 * part) for part in colour)
    return r, g, b
