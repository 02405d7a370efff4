"""Options of random tabletop scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from eyehand.errors import InputError
from eyehand.perception.superquadric import Kind

from .tabletop_scene import Family

MAX_OBJECTS = 15
"""Maximum number of objects: more leave no room for a hand between them."""
MIN_OBJECTS: dict[Family, int] = {
    "separate": 0,
    "touching": 2,
    "stacked": 2,
    "dropped": 1,
    "piled": 2,
}
"""Minimum number of objects in each family."""
MIN_IMAGE_SIZE = (32, 24)
MAX_IMAGE_SIZE = (4096, 4096)


STRAIGHT_KINDS: tuple[Kind, ...] = ("sphere", "cylinder", "ellipsoid", "box", "superquadric")
"""Solids of random scenes. Tapered solids exist only in staged scenes."""


@dataclass(frozen=True)
class ViewOptions:
    """Range of camera poses of a scene, and the image size.

    Raises
    ------
    InputError
        If a range is empty or reversed, or a value is out of its bounds.
    """

    image_size: tuple[int, int] = (640, 480)
    """Columns and rows, px: more resolve smaller objects and cost time in every stage."""
    elevation_range: tuple[float, float] = (np.pi / 6, 65 * np.pi / 180)
    """Minimum and maximum angle of the optical axis below the horizon, rad. Low views hide more
    behind other objects; high views hide the sides."""
    distance_range: tuple[float, float] = (0.6, 1.1)
    """Minimum and maximum distance to the objects' middle, m: noise grows with its square."""

    def __post_init__(self) -> None:
        for size, low, high in zip(self.image_size, MIN_IMAGE_SIZE, MAX_IMAGE_SIZE, strict=True):
            if not low <= size <= high:
                raise InputError(
                    f"image_size must lie in {MIN_IMAGE_SIZE} .. {MAX_IMAGE_SIZE} px, "
                    f"got {self.image_size}"
                )
        check_range("elevation_range", self.elevation_range, 0.05, np.pi / 2, "rad")
        check_range("distance_range", self.distance_range, 0.2, 5.0, "m")


@dataclass(frozen=True)
class TabletopOptions:
    """Options of :func:`make_scene`.

    Raises
    ------
    InputError
        If a name is unknown, a range is empty or reversed, or a value is out of its bounds.
    """

    family: Family = "separate"
    """Arrangement of the objects. Standing: ``separate`` (at least `min_gap` between all objects),
    ``touching`` (every object touches another), ``stacked`` (some rest on others). Fallen, in any
    orientation: ``dropped`` (apart from each other), ``piled`` (onto each other)."""
    count_range: tuple[int, int] = (4, 8)
    """Minimum and maximum number of objects; 0 is an empty table (family ``separate`` only)."""
    kinds: tuple[Kind, ...] = STRAIGHT_KINDS
    """Kinds of solids, drawn with equal probability."""
    width_range: tuple[float, float] = (0.03, 0.12)
    """Minimum and maximum horizontal extent of an upright object, m; a hand must span it."""
    height_range: tuple[float, float] = (0.03, 0.25)
    """Minimum and maximum extent along an object's third axis, m."""
    density_range: tuple[float, float] = (150.0, 600.0)
    """Mass over volume, kg/m³. The default is that of hollow household goods."""
    table_size: tuple[float, float] = (1.2, 0.8)
    """Extent of the table along world x and y, m."""
    table_height: float = 0.0
    """World z of the table's top, m."""
    work_area: tuple[float, float] = (0.56, 0.48)
    """Objects stand inside this rectangle in the middle of the table, m: smaller is denser.
    Dropped objects start inside it and may end anywhere on the table."""
    min_gap: float = 0.015
    """Minimum distance between separate objects and between groups of standing objects, m. Also
    the smallest horizontal distance between dropped objects before they fall."""
    pile_spread: float = 0.5
    """Radius of the disc onto which piled objects fall, as a share of the disc that they would
    cover side by side. Lower makes higher piles that hide more; higher leaves more objects on the
    table."""
    view: ViewOptions = field(default_factory=ViewOptions)
    """Camera poses and image size."""

    def __post_init__(self) -> None:
        _check_name("family", self.family, get_args(Family))
        if not self.kinds:
            raise InputError(f"kinds must name one or more of {', '.join(STRAIGHT_KINDS)}")
        for kind in self.kinds:
            _check_name("kinds", kind, STRAIGHT_KINDS)
        fewest = MIN_OBJECTS[self.family]
        check_range("count_range", self.count_range, fewest, MAX_OBJECTS, "objects")
        if any(count != int(count) for count in self.count_range):
            raise InputError(f"count_range must hold whole numbers, got {self.count_range}")
        if self.family == "stacked" and not {"box", "cylinder"} & set(self.kinds):
            raise InputError(
                "family stacked needs kinds with a flat top, box or cylinder, "
                f"got {', '.join(self.kinds)}"
            )
        check_range("width_range", self.width_range, 0.005, 0.5, "m")
        check_range("height_range", self.height_range, 0.005, 0.5, "m")
        check_range("density_range", self.density_range, 10.0, 20000.0, "kg/m³")
        self._check_lengths()

    def _check_lengths(self) -> None:
        for name, table, work in zip("xy", self.table_size, self.work_area, strict=True):
            if not 0 < work <= table <= 10:
                raise InputError(
                    f"table_size must lie in (0, 10] m and work_area inside it, "
                    f"got {table} and {work} along {name}"
                )
        for name, max_value in (("min_gap", 0.5), ("pile_spread", 2.0)):
            value = getattr(self, name)
            if not 0.0 <= value <= max_value:
                raise InputError(f"{name} must lie in [0, {max_value:g}], got {value}")
        if not -10.0 <= self.table_height <= 10.0:
            raise InputError(f"table_height must lie in [-10, 10] m, got {self.table_height}")


def check_range(
    name: str, values: tuple[float, float], lowest: float, highest: float, unit: str
) -> None:
    """Raise an `InputError` unless lowest <= values[0] <= values[1] <= highest."""
    if len(values) != 2 or not lowest <= values[0] <= values[1] <= highest:
        raise InputError(
            f"{name} must be two rising values in [{lowest:.3g}, {highest:.3g}] {unit}".rstrip()
            + f", got {tuple(values)}"
        )


def _check_name(option: str, name: str, names: Sequence[str]) -> None:
    if name not in names:
        raise InputError(f"{option} must be of {', '.join(names)}, got {name!r}")
