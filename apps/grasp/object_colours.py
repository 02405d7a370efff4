"""Colour numbers that objects keep over successive captures, matched by position."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..scene_picture import PALETTE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject

MAX_DISPLACEMENT = 0.06
"""Maximum displacement of an object between two captures, m. Pushed objects move at most this far.
An object that appears under a removed one usually lies farther away."""


def colour_numbers(
    captures: Sequence[Sequence[SceneObject]], removed: Mapping[int, int]
) -> tuple[dict[int, int], ...]:
    """Assign colour numbers to the objects of all captures, so that each object keeps its number.

    Objects are matched to earlier positions by the assignment with the smallest total distance. A
    new object gets an unused number or, beyond the palette, the number unused for longest. The
    numbers of a capture are unique and do not depend on later captures.

    Parameters
    ----------
    captures
        Objects on the table in each capture.
    removed
        Label of the object that was put away after a capture, by capture index. An object that
        appears at its position is a new one.

    Returns
    -------
    tuple of dict
        Numbers for :func:`~..scene_picture.colour_of`, by label, one dict per capture.
    """
    # The last position and capture index of each number.
    known: dict[int, tuple[NDArray[np.float64], int]] = {}
    numbered: list[dict[int, int]] = []
    for index, items in enumerate(captures):
        numbers = _match_objects(items, known)
        for item in items:
            if item.label not in numbers:
                numbers[item.label] = _free_number(set(numbers.values()), known)
                known.pop(numbers[item.label], None)
        for item in items:
            known[numbers[item.label]] = _position(item), index
        gone = numbers.get(removed.get(index, -1))
        if gone is not None:
            known[gone] = np.full(3, np.inf), index
        numbered.append({item.label: numbers[item.label] for item in items})
    return tuple(numbered)


def _match_objects(
    items: Sequence[SceneObject], known: Mapping[int, tuple[NDArray[np.float64], int]]
) -> dict[int, int]:
    """Return the numbers of the objects that match an earlier one, by label."""
    numbers = [number for number, (position, _) in known.items() if np.isfinite(position).all()]
    if not numbers or not items:
        return {}
    before = np.array([known[number][0] for number in numbers])
    now = np.array([_position(item) for item in items])
    apart = np.linalg.norm(now[:, None] - before, axis=2)
    # Clip large distances: a far object must not change the match of near ones.
    rows, columns = linear_sum_assignment(np.minimum(apart, MAX_DISPLACEMENT))
    return {
        items[row].label: numbers[column]
        for row, column in zip(rows, columns, strict=True)
        if apart[row, column] < MAX_DISPLACEMENT
    }


def _free_number(shown: set[int], known: Mapping[int, tuple[NDArray[np.float64], int]]) -> int:
    """Return a number for a new object that no shown object has."""
    for number in range(1, len(PALETTE) + 1):
        if number not in shown and number not in known:
            return number
    unused = [number for number in known if number not in shown]
    if unused:
        return min(unused, key=lambda number: known[number][1])
    return next(number for number in count(1) if number not in shown)


def _position(item: SceneObject) -> NDArray[np.float64]:
    """Return the centre of the fitted solid, or of the points without one, (3,), m."""
    solid = item.fit.superquadric if item.fit else None
    return item.points.mean(axis=0) if solid is None else solid.centre
