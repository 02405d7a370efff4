"""Sweeps of objects that are increasingly hard to grasp, at known poses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping import PickOptions

from ...bench.sweep import Sweep, Trial
from .stress_objects import object_on_table
from .stress_trial import StressOutcome, stress_cell

PLACED = "in the tray at the end"
"""The default requirement of a trial."""
MM = 1e-3
LOW_ROLLING_M = 2e-5
"""Rolling friction of rolling objects, m: a hundredth of the default, as glass on glass."""
LOW_FRICTION = 0.5
"""Friction of the hand's pads in the sweep of the weight."""
MAX_GRASPABLE_MM = 115.0
"""Maximum width that the hand can span, mm. Wider objects must be refused."""
CLEAR_OF_TRAY = (-0.1, 0.0)
"""Position of long objects, clear of the tray, m."""


def shape_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over the shape of the object."""
    refused = f"{PLACED}, or refused by its width; above {MAX_GRASPABLE_MM:g} mm refused"
    widths = (40.0, 70.0, 90.0, 100.0, 110.0, 120.0, 140.0, 200.0)
    rollers = (60.0, 45.0, 35.0, 28.0, 22.0, 16.0, 10.0)
    return (
        Sweep("width", "width of a box", "mm", widths, 200.0, _wide, refused),
        *(
            Sweep(name, axis, unit, values, bound, _shape_trial(make, rolling), PLACED)
            for name, axis, unit, values, bound, make, rolling in (
                ("plate", "thickness of a plate of 70 mm", "mm",
                 (40.0, 30.0, 25.0, 20.0, 15.0, 12.0, 10.0, 8.0, 5.0), 15.0, _plate, None),
                ("tall", "height over width of a box of 35 mm", "",
                 (2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0), 6.0, _tall_box, None),
                ("lens", "width over height of an ellipsoid of 70 mm", "",
                 (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0), 2.5, _lens, None),
                ("stick", "length over width of a lying stick of 24 mm", "",
                 (2.0, 4.0, 6.0, 8.0, 11.0, 15.0, 19.0, 24.0), 11.0, _stick, None),
                ("ball-small", "diameter of a small rolling ball", "mm",
                 rollers, 35.0, partial(_ball, mass=0.1), LOW_ROLLING_M),
                ("ball-large", "diameter of a large rolling ball", "mm",
                 (60.0, 75.0, 90.0, 105.0, 115.0, 125.0, 140.0), 90.0,
                 partial(_ball, mass=0.2), LOW_ROLLING_M),
                ("roller", "diameter of a rolling cylinder of 100 mm", "mm",
                 rollers, 28.0, _roller, LOW_ROLLING_M),
            )
        ),
    )  # fmt: skip


def load_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over weight, friction and neighbours of the object."""
    masses = (0.1, 0.3, 0.6, 0.9, 1.2, 1.5, 2.5, 4.0)
    frictions = (1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02)
    gaps = (40.0, 30.0, 20.0, 10.0, 5.0, 2.0, 0.0)
    mass_axis = f"mass of a can of 60 mm at friction {LOW_FRICTION:g}"
    return (
        Sweep("mass", mass_axis, "kg", masses, 0.9, _heavy, PLACED),
        Sweep("friction", "friction of the hand on a can of 0.3 kg", "",
              frictions, 0.3, _slippery, PLACED),
        Sweep("neighbour", "gap between a box of 45 mm and one wall", "mm",
              gaps, 5.0, partial(_beside_walls, sides=(1.0,)), f"all {PLACED}"),
        Sweep("slot", "gap between a box of 45 mm and two walls", "mm",
              gaps, 5.0, partial(_beside_walls, sides=(1.0, -1.0)), f"all {PLACED}"),
    )  # fmt: skip


def _clear_known(
    objects: Sequence[TabletopObject], seed: int, options: PickOptions, friction: float = 1.0
) -> StressOutcome:
    """Clear a table of objects with known poses."""
    return stress_cell(objects, seed, options, friction=friction).clear(len(objects) + 2)


def _shape_trial(
    make: Callable[[float, int], TabletopObject], rolling: float | None
) -> Callable[[float, int, PickOptions], Trial]:
    """Return the trial of an object that `make` builds from a value and a seed."""

    def attempt(value: float, seed: int, options: PickOptions) -> Trial:
        stress = stress_cell([make(value, seed)], seed, options)
        if rolling is not None:
            stress.set_rolling(rolling)
        return stress.clear().trial()

    return attempt


def _plate(thickness_mm: float, seed: int) -> TabletopObject:
    return object_on_table("box", (0.07, 0.07, MM * thickness_mm), seed)


def _tall_box(ratio: float, seed: int) -> TabletopObject:
    return object_on_table("box", (0.035, 0.035, 0.035 * ratio), seed)


def _lens(ratio: float, seed: int) -> TabletopObject:
    return object_on_table("ellipsoid", (0.07, 0.07, 0.07 / ratio), seed)


def _stick(ratio: float, seed: int) -> TabletopObject:
    return object_on_table("box", (0.024, 0.024 * ratio, 0.024), seed, position=CLEAR_OF_TRAY)


def _ball(diameter_mm: float, seed: int, mass: float) -> TabletopObject:
    diameter = MM * diameter_mm
    return object_on_table("sphere", (diameter, diameter, diameter), seed, mass=mass)


def _roller(diameter_mm: float, seed: int) -> TabletopObject:
    diameter = MM * diameter_mm
    return object_on_table("cylinder", (diameter, diameter, 0.1), seed, lying=True)


def _wide(width_mm: float, seed: int, options: PickOptions) -> Trial:
    width = MM * width_mm
    outcome = _clear_known([object_on_table("box", (width, width, 0.08), seed)], seed, options)
    refused = outcome.refused and "width" in outcome.failure
    if width_mm > MAX_GRASPABLE_MM:
        return outcome.trial(refused, f"not refused by its width; {outcome.failure}")
    return outcome.trial(refused or not outcome.left)


def _heavy(mass: float, seed: int, options: PickOptions) -> Trial:
    can = object_on_table("cylinder", (0.06, 0.06, 0.12), seed, mass=mass)
    return _clear_known([can], seed, options, LOW_FRICTION).trial()


def _slippery(friction: float, seed: int, options: PickOptions) -> Trial:
    can = object_on_table("cylinder", (0.06, 0.06, 0.12), seed, mass=0.3)
    return _clear_known([can], seed, options, friction).trial()


def _beside_walls(
    gap_mm: float, seed: int, options: PickOptions, *, sides: tuple[float, ...]
) -> Trial:
    width, thickness = 0.045, 0.05
    offset = 0.5 * (width + thickness) + MM * gap_mm
    walls = [
        object_on_table(
            "box", (thickness, 0.09, 0.09), seed, name=f"wall_{k}", offset=(side * offset, 0.0)
        )
        for k, side in enumerate(sides)
    ]
    box = object_on_table("box", (width, width, 0.09), seed)
    return _clear_known([box, *walls], seed, options).trial()
