"""The Object Segmentation Database: how its files code labels and name groups."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

OSD_OBJECT = 10
"""In the Object Segmentation Database object k and its parts have labels 10 k to 10 k + 9, from
k = 2. Labels below 20 are the table and the background."""
OSD_FIRST_OBJECT = 20
OSD_GROUPS = {
    "learn": {"boxes": 17, "stacked boxes": 8, "occluded objects": 8, "cylindric objects": 12},
    "test": {
        "boxes": 16,
        "stacked boxes": 8,
        "occluded objects": 7,
        "cylindric objects": 12,
        "mixed objects": 12,
        "complex scenes": 11,
    },
}
"""Groups of that database and their number of frames, in file order (Richtsfeld, Mörwald, Prankl,
Zillich and Vincze, "Segmentation of Unknown Objects in Indoor Environments", IROS 2012)."""


def osd_objects(labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the object of each label of the database, 0 = none."""
    return np.where(labels < OSD_FIRST_OBJECT, 0, labels // OSD_OBJECT)


def osd_group(stem: str) -> str | None:
    """Return the group of a frame of the Object Segmentation Database, e.g. of ``learn17``."""
    found = re.fullmatch(r"(learn|test)(\d+)", stem)
    if found is None:
        return None
    number = int(found[2])
    for group, count in OSD_GROUPS[found[1]].items():
        if number < count:
            return group
        number -= count
    return None


def looks_like_osd(label: NDArray[np.integer]) -> bool:
    """Return whether objects are numbered in tens and the background has labels too."""
    numbers = np.unique(label)
    tens = numbers[numbers >= OSD_FIRST_OBJECT]
    return len(tens) > 0 and 1 in numbers and bool(np.all(tens % OSD_OBJECT == 0))
