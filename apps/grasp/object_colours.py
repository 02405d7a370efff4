"""Colours that stay with their objects: from look to look an object is known by its place."""

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

SAME_PLACE = 0.06
"""An object was not moved farther than this between two looks, m: what is pushed aside goes this
far, and what appears under an object that was taken lies mostly farther off."""


def colour_numbers(
    looks: Sequence[Sequence[SceneObject]], taken: Mapping[int, int]
) -> tuple[dict[int, int], ...]:
    """Number the objects of all looks so that each keeps its number, and its colour with it.

    An object takes the number of the nearest one of the looks before; all of a look together, so
    that the sum of their ways is least. One that was not there before takes a number that none had
    yet or, where the colours told apart best are used up, the one unused for longest. A look's
    numbers do not depend on the looks after it, and no two of its objects share one.

    Parameters
    ----------
    looks
        What stood on the table, look by look.
    taken
        Label of the object that was put away after a look, by the look's place in order: what
        comes to light in its place is another object.

    Returns
    -------
    tuple of dict
        Numbers for :func:`~..scene_picture.colour_of`, by label, one dict for each look.
    """
    # The number's last place and look.
    known: dict[int, tuple[NDArray[np.float64], int]] = {}
    numbered: list[dict[int, int]] = []
    for time, items in enumerate(looks):
        numbers = _known_again(items, known)
        for item in items:
            if item.label not in numbers:
                numbers[item.label] = _free_number(set(numbers.values()), known)
                known.pop(numbers[item.label], None)
        for item in items:
            known[numbers[item.label]] = _place(item), time
        gone = numbers.get(taken.get(time, -1))
        if gone is not None:
            known[gone] = np.full(3, np.inf), time
        numbered.append({item.label: numbers[item.label] for item in items})
    return tuple(numbered)


def _known_again(
    items: Sequence[SceneObject], known: Mapping[int, tuple[NDArray[np.float64], int]]
) -> dict[int, int]:
    """Numbers of the objects that were seen before, by label."""
    numbers = [number for number, (place, _) in known.items() if np.isfinite(place).all()]
    if not numbers or not items:
        return {}
    before = np.array([known[number][0] for number in numbers])
    now = np.array([_place(item) for item in items])
    apart = np.linalg.norm(now[:, None] - before, axis=2)
    # What is too far counts the same however far it is: else near ones would be torn apart.
    rows, columns = linear_sum_assignment(np.minimum(apart, SAME_PLACE))
    return {
        items[row].label: numbers[column]
        for row, column in zip(rows, columns, strict=True)
        if apart[row, column] < SAME_PLACE
    }


def _free_number(shown: set[int], known: Mapping[int, tuple[NDArray[np.float64], int]]) -> int:
    """Give a number for what is new: none of those shown, which come with their objects."""
    for number in range(1, len(PALETTE) + 1):
        if number not in shown and number not in known:
            return number
    unused = [number for number in known if number not in shown]
    if unused:
        return min(unused, key=lambda number: known[number][1])
    return next(number for number in count(1) if number not in shown)


def _place(item: SceneObject) -> NDArray[np.float64]:
    solid = item.fit.superquadric if item.fit else None
    return item.points.mean(axis=0) if solid is None else solid.centre
