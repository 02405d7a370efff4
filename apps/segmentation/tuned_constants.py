"""The constants of the segmentation that were chosen on data, and their temporary replacement."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

PACKAGE = "eyehand.perception.segmentation"
JOIN = "join_patches"
"""Module of the log-odds."""


class Constant(NamedTuple):
    """A named constant of a module of the segmentation. Compiled functions must not use it."""

    module: str
    """Module within the package."""
    name: str
    """Name of the constant."""

    def value(self) -> float:
        """Return its present value."""
        return getattr(stage_module(self.module), self.name)

    def scaled(self, factor: float) -> float:
        """Return its present value times a factor; a whole number stays one."""
        value = self.value()
        return type(value)(value * factor)


OTHERS = (
    Constant("patch_edges", "LONG_CONTACT"),
    Constant("patch_edges", "MILD_ANGLE"),
    Constant("patch_edges", "FULL_ANGLE"),
    Constant(JOIN, "SLIVER_WIDTH"),
    Constant(JOIN, "REGION_PRIOR"),
    Constant(JOIN, "MIN_TOUCHING"),
    Constant("remove_steep", "MIN_COSINE"),
    Constant("remove_steep", "MAX_AREA"),
    Constant("remove_steep", "MAX_STEEP_SHARE"),
    Constant("join_fragments", "MAX_SIZE_SHARE"),
    Constant("parallel_planes", "MIN_VISIBLE"),
    Constant("select_objects", "HULL_MARGIN"),
    Constant("find_containers", "WALL_MARGIN"),
    Constant("select_objects", "FOOT_SHARE"),
    Constant("select_objects", "MIN_FOOT_INSIDE"),
    Constant("above_support", "OVERHANG"),
    Constant("join_floating", "MAX_AREA"),
    Constant("select_supports", "MIN_RIVAL_SCORE"),
    Constant("support_plane", "TUKEY_WIDTH"),
    Constant("support_plane", "CANDIDATES"),
)
"""The main constants besides the log-odds."""


def log_odds() -> tuple[Constant, ...]:
    """Return the prior and all gains of the join, in the order of the file."""
    names = [n for n in vars(stage_module(JOIN)) if n == "PRIOR" or n.endswith("_GAIN")]
    return tuple(Constant(JOIN, name) for name in names)


@contextmanager
def replaced(values: Mapping[Constant, float]) -> Iterator[None]:
    """Replace constants as long as the context lasts.

    They are no options, because users should not turn them. Only the measurement does.
    """
    before = {constant: constant.value() for constant in values}
    try:
        for constant, value in values.items():
            setattr(stage_module(constant.module), constant.name, value)
        yield
    finally:
        for constant, value in before.items():
            setattr(stage_module(constant.module), constant.name, value)


def stage_module(name: str) -> Any:
    """Return a module of the segmentation. Some functions have the name of their module."""
    return importlib.import_module(f"{PACKAGE}.{name}")
