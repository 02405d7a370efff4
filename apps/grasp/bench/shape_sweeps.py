"""Shapes and loads that are ever harder to grasp, at a known pose."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ...bench.sweep import Sweep, Trial
from .stress_objects import standing
from .stress_trial import Ended, bench_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from eyehand.data_synth.scenes import TabletopObject
    from eyehand.grasping import PickOptions

PLACED = "in the tray at the end"
"""What is right where nothing else is asked."""
MM = 1e-3
SMOOTH_ROLLING_M = 2e-5
"""Rolling friction of what rolls, m: a hundredth of the usual, as of glass on glass."""
HARD_FRICTION = 0.5
"""Of the hand's pads where weight is swept."""
BEYOND_HAND_MM = 115.0
"""Wider than this must be refused."""
CLEAR_OF_TRAY = (-0.1, 0.0)
"""Where what is long lies, m."""


def shape_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Sweeps over the object's shape."""
    return (
        Sweep(
            name="width",
            axis="box wider and wider; past the hand: refused",
            unit="mm",
            values=(40.0, 70.0, 90.0, 100.0, 110.0, 120.0, 140.0, 200.0),
            holds_to=200.0,
            attempt=_wide,
            right=f"{PLACED}, or refused by its width; above {BEYOND_HAND_MM:g} mm refused",
        ),
        _shape(
            "plate",
            "plate of 70 mm, thinner and thinner",
            "mm",
            (40.0, 30.0, 25.0, 20.0, 15.0, 12.0, 10.0, 8.0, 5.0),
            15.0,
            lambda t, seed: standing("box", (0.07, 0.07, MM * t), seed),
        ),
        _shape(
            "tall",
            "box of 35 mm, height over width",
            "",
            (2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0),
            6.0,
            lambda r, seed: standing("box", (0.035, 0.035, 0.035 * r), seed),
        ),
        _shape(
            "lens",
            "ellipsoid of 70 mm, width over height",
            "",
            (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0),
            2.5,
            lambda r, seed: standing("ellipsoid", (0.07, 0.07, 0.07 / r), seed),
        ),
        _shape(
            "stick",
            "lying stick of 24 mm, length over width",
            "",
            (2.0, 4.0, 6.0, 8.0, 11.0, 15.0, 19.0, 24.0),
            11.0,
            lambda r, seed: standing("box", (0.024, 0.024 * r, 0.024), seed, place=CLEAR_OF_TRAY),
        ),
        _shape(
            "ball-small",
            "ball that rolls, smaller and smaller",
            "mm",
            (60.0, 45.0, 35.0, 28.0, 22.0, 16.0, 10.0),
            35.0,
            lambda d, seed: _ball(d, seed, 0.1),
            rolling=SMOOTH_ROLLING_M,
        ),
        _shape(
            "ball-large",
            "ball that rolls, larger and larger",
            "mm",
            (60.0, 75.0, 90.0, 105.0, 115.0, 125.0, 140.0),
            90.0,
            lambda d, seed: _ball(d, seed, 0.2),
            rolling=SMOOTH_ROLLING_M,
        ),
        _shape(
            "roller",
            "lying cylinder of 100 mm that rolls, thinner and thinner",
            "mm",
            (60.0, 45.0, 35.0, 28.0, 22.0, 16.0, 10.0),
            28.0,
            lambda d, seed: standing("cylinder", (MM * d, MM * d, 0.1), seed, lying=True),
            rolling=SMOOTH_ROLLING_M,
        ),
    )


def load_sweeps() -> tuple[Sweep[PickOptions], ...]:
    """Sweeps over weight, friction and what stands beside the object."""
    return (
        Sweep(
            name="mass",
            axis=f"can of 60 mm, heavier and heavier, at friction {HARD_FRICTION:g}",
            unit="kg",
            values=(0.1, 0.3, 0.6, 0.9, 1.2, 1.5, 2.5, 4.0),
            holds_to=0.9,
            attempt=_heavy,
            right=PLACED,
        ),
        Sweep(
            name="friction",
            axis="can of 0.3 kg, friction of the hand",
            unit="",
            values=(1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02),
            holds_to=0.3,
            attempt=_slippery,
            right=PLACED,
        ),
        *(
            Sweep(
                name=name,
                axis=f"{told} a box of 45 mm, gap",
                unit="mm",
                values=(40.0, 30.0, 20.0, 10.0, 5.0, 2.0, 0.0),
                holds_to=holds_to,
                attempt=partial(_beside, sides=sides),
                right="all in the tray at the end",
            )
            for name, told, sides, holds_to in (
                ("neighbour", "a wall beside", (1.0,), 5.0),
                ("slot", "a wall on either side of", (1.0, -1.0), 5.0),
            )
        ),
    )


def tried(
    objects: Sequence[TabletopObject], seed: int, options: PickOptions, *, friction: float = 1.0
) -> Ended:
    """Clear a table of objects whose poses are known."""
    return bench_of(objects, seed, options, friction=friction).clear(len(objects) + 2)


def _shape(
    name: str,
    axis: str,
    unit: str,
    values: tuple[float, ...],
    holds_to: float,
    make: Callable[[float, int], TabletopObject],
    rolling: float | None = None,
) -> Sweep[PickOptions]:
    def attempt(value: float, seed: int, options: PickOptions) -> Trial:
        bench = bench_of([make(value, seed)], seed, options)
        if rolling is not None:
            bench.set_rolling(rolling)
        return bench.clear().judged()

    return Sweep(name, axis, unit, values, holds_to, attempt, PLACED)


def _ball(diameter_mm: float, seed: int, mass: float) -> TabletopObject:
    across = MM * diameter_mm
    return standing("sphere", (across, across, across), seed, mass=mass)


def _wide(width_mm: float, seed: int, options: PickOptions) -> Trial:
    width = MM * width_mm
    ended = tried([standing("box", (width, width, 0.08), seed)], seed, options)
    refused = ended.refused and "width" in ended.says
    if width_mm > BEYOND_HAND_MM:
        return ended.judged(refused, f"not refused by its width; {ended.says}")
    return ended.judged(refused or not ended.left)


def _heavy(mass: float, seed: int, options: PickOptions) -> Trial:
    item = standing("cylinder", (0.06, 0.06, 0.12), seed, mass=mass)
    return tried([item], seed, options, friction=HARD_FRICTION).judged()


def _slippery(friction: float, seed: int, options: PickOptions) -> Trial:
    item = standing("cylinder", (0.06, 0.06, 0.12), seed, mass=0.3)
    return tried([item], seed, options, friction=friction).judged()


def _beside(gap_mm: float, seed: int, options: PickOptions, *, sides: tuple[float, ...]) -> Trial:
    wide, thick = 0.045, 0.05
    away = 0.5 * (wide + thick) + MM * gap_mm
    walls = [
        standing("box", (thick, 0.09, 0.09), seed, name=f"wall_{k}", aside=(side * away, 0.0))
        for k, side in enumerate(sides)
    ]
    box = standing("box", (wide, wide, 0.09), seed)
    return tried([box, *walls], seed, options).judged()
