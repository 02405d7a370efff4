"""Split of household objects into a development half and a held-out half, by their names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeVar

from eyehand.errors import InputError

Item = TypeVar("Item")
Split = Literal["all", "development", "held-out"]
"""Which objects of a folder are drawn. Settings are chosen on the development half only."""

IN_BOTH_FOLDERS: dict[str, Split] = {"mug": "held-out", "pepto_bismol": "development"}
"""Half of the names that both folders of the clutter-removal benchmark contain. Alternation would
put the two meshes of a name into different halves. The whole list is in docs/household_objects.md.
"""


def half_of(names: Sequence[str]) -> dict[str, Split]:
    """Return the half of each name: every other one in the order of the names.

    Names of `IN_BOTH_FOLDERS` keep their half in every folder.
    """
    halves: tuple[Split, Split] = ("development", "held-out")
    return {
        name: IN_BOTH_FOLDERS.get(name, halves[number % 2])
        for number, name in enumerate(sorted(set(names)))
    }


def select_half(items: Sequence[Item], names: Sequence[str], split: Split) -> tuple[Item, ...]:
    """Return the items of a half.

    Parameters
    ----------
    items
        Objects of a folder.
    names
        Name of each item: the name of its file without suffix.
    split
        The half, or "all".

    Raises
    ------
    InputError
        If the half is empty.
    """
    halves = half_of(names)
    chosen = tuple(
        item
        for item, name in zip(items, names, strict=True)
        if split == "all" or halves[name] == split
    )
    if not chosen:
        raise InputError(f"{len(items)} objects are too few for two halves: none is {split}")
    return chosen
