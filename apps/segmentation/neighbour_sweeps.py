"""Sweeps of neighbouring objects: side by side, leaning, stacked, occluding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from eyehand.data_synth.render import StagedObject, StagedScene, render_staged
from eyehand.data_synth.scenes import box, cylinder, rod, tapered_box

from ..bench import Sweep, Trial
from .camera_sweeps import COLOURS, MM, view_around
from .stress_trial import SegmentCallable, try_scene

RED, BLUE, GREEN = COLOURS[:3]
TWO = "both objects found, none more"
TWO_OR_UNSURE = "both found, or one that is marked as ambiguous"


def neighbour_sweeps() -> tuple[Sweep[SegmentCallable], ...]:
    """Return the sweeps of gaps, leaning boxes, stacks, flush faces, occluders and the border."""
    return (*_gap_sweeps(), *_hidden_edge_sweeps())


def _gap_sweeps() -> tuple[Sweep[SegmentCallable], ...]:
    """Return the sweeps of gaps and stacks."""
    return (
        Sweep(
            name="gap",
            axis="gap between unequal boxes",
            unit="mm",
            values=(20, 15, 10, 6, 4, 3, 2, 1, 0),
            holds_to=0,
            attempt=_gap,
            right=TWO,
        ),
        Sweep(
            name="gap-aligned",
            axis="gap between equal boxes in line",
            unit="mm",
            values=(20, 15, 10, 8, 6, 4, 3, 2, 1),
            holds_to=8,
            attempt=_gap_aligned,
            right=TWO,
        ),
        Sweep(
            name="lean",
            axis="gap at the top of a leaning box",
            unit="mm",
            values=(6, 5, 4, 3, 2, 1, 0),
            holds_to=0,
            attempt=_lean,
            right=TWO,
        ),
        Sweep(
            name="stack",
            axis="upper box narrower on each side",
            unit="mm",
            values=(20, 15, 10, 8, 6, 4, 2, 0),
            holds_to=15,
            attempt=_stack,
            right=TWO_OR_UNSURE,
        ),
        Sweep(
            name="tapered-stack",
            axis="taper of two equal stacked solids",
            unit="°",
            values=(15, 12, 10, 8, 6, 4, 2, 0),
            holds_to=6,
            attempt=_tapered_stack,
            right=TWO_OR_UNSURE,
        ),
    )


def _hidden_edge_sweeps() -> tuple[Sweep[SegmentCallable], ...]:
    """Return the sweeps of flush faces, occluders and the image border."""
    return (
        Sweep(
            name="flush",
            axis="step between touching boxes",
            unit="mm",
            values=(20, 15, 10, 8, 6, 4, 2, 0),
            holds_to=None,
            attempt=_flush,
            right=TWO_OR_UNSURE,
        ),
        Sweep(
            name="flush-colour",
            axis="the same step, two colours",
            unit="mm",
            values=(20, 15, 10, 8, 6, 4, 2, 0),
            holds_to=None,
            attempt=_flush_colour,
            right=TWO,
        ),
        Sweep(
            name="occluded-box",
            axis="bar before a box 180 mm wide",
            unit="mm",
            values=(10, 20, 30, 40, 60, 80, 100, 120, 140),
            holds_to=100,
            attempt=_occluded_box,
            right=TWO,
        ),
        Sweep(
            name="occluded-roll",
            axis="bar before a roll 180 mm long",
            unit="mm",
            values=(10, 20, 30, 40, 60, 80, 100, 120, 140),
            holds_to=100,
            attempt=_occluded_roll,
            right=TWO,
        ),
        Sweep(
            name="border",
            axis="object cut off by the border",
            unit="%",
            values=(0, 20, 40, 60, 70, 80, 90, 95),
            holds_to=80,
            attempt=_border,
            right=TWO,
        ),
    )


def _gap(gap: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 11])
    wide, other = rng.uniform(0.05, 0.09, 2)
    tall, low = rng.uniform(0.08, 0.12), rng.uniform(0.04, 0.07)
    back = rng.uniform(0.012, 0.02)
    objects = (
        StagedObject(box(wide, 0.06, tall), (-(wide + gap * MM) / 2, 0.0, 0.0), colour=RED),
        StagedObject(box(other, 0.06, low), ((other + gap * MM) / 2, back, 0.0), colour=BLUE),
    )
    return try_scene(method, StagedScene(objects, view_around(rng, (35, 50), turn=25.0)), seed)


def _gap_aligned(gap: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 13])
    wide, deep, tall = rng.uniform(0.05, 0.09, 3)
    objects = tuple(
        StagedObject(box(wide, deep, tall), (side * (wide + gap * MM) / 2, 0.0, 0.0), colour=colour)
        for side, colour in ((-1, RED), (1, BLUE))
    )
    return try_scene(method, StagedScene(objects, view_around(rng, (35, 50), turn=25.0)), seed)


def _lean(gap: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 17])
    wide, tall = 0.03, rng.uniform(0.09, 0.12)
    lean = np.radians(rng.uniform(12, 25))
    # The lower right corner of the leaning box lies on the table, the upper one beside the face.
    lift = wide / 2 * np.sin(lean)
    touch = wide / 2 * np.cos(lean) + tall * np.sin(lean) + gap * MM
    back = rng.choice([-1, 1]) * rng.uniform(0.008, 0.015)
    objects = (
        StagedObject(box(wide, 0.06, tall), (0.0, 0.0, lift), lean=lean, colour=BLUE),
        StagedObject(box(0.06, 0.06, 0.13), (touch + 0.03, back, 0.0), colour=RED),
    )
    return try_scene(method, StagedScene(objects, view_around(rng, (35, 50), turn=40.0)), seed)


def _stack(narrower: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 19])
    x, y = rng.uniform(0.08, 0.1, 2)
    low, high = rng.uniform(0.04, 0.07, 2)
    less = 2 * narrower * MM
    objects = (
        StagedObject(box(x, y, low), colour=RED),
        StagedObject(box(x - less, y - less, high), (0.0, 0.0, low), colour=BLUE),
    )
    return try_scene(
        method, StagedScene(objects, view_around(rng, (25, 45), turn=40.0)), seed, ambiguous=True
    )


def _tapered_stack(taper: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 23])
    x, y = rng.uniform(0.075, 0.095, 2)
    tall = rng.uniform(0.05, 0.065)
    less = 2 * tall * np.tan(np.radians(taper))
    solid = tapered_box((x, y), (x - less, y - less), tall)
    objects = (
        StagedObject(solid, colour=RED),
        StagedObject(solid, (0.0, 0.0, tall), colour=BLUE),
    )
    return try_scene(
        method, StagedScene(objects, view_around(rng, (25, 45), turn=40.0)), seed, ambiguous=True
    )


def _flush(step: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, _flush_scene(step, seed, same=True), seed, colour=True, ambiguous=True)


def _flush_colour(step: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, _flush_scene(step, seed, same=False), seed, colour=True)


def _flush_scene(step: float, seed: int, *, same: bool) -> StagedScene:
    """Two boxes of equal height and depth side by side, one set back by `step` mm."""
    rng = np.random.default_rng([seed, 29])
    one, other = rng.uniform(0.05, 0.09, 2)
    deep, tall = rng.uniform(0.05, 0.08, 2)
    objects = (
        StagedObject(box(one, deep, tall), (-one / 2, 0.0, 0.0), colour=RED),
        StagedObject(
            box(other, deep, tall), (other / 2, step * MM, 0.0), colour=RED if same else BLUE
        ),
    )
    return StagedScene(objects, view_around(rng, (35, 50), turn=30.0))


def _occluded_box(width: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 31])
    behind = StagedObject(box(0.18, 0.06, rng.uniform(0.06, 0.08)), (0.0, 0.04, 0.0), colour=RED)
    return _behind_a_bar(behind, width, rng, seed, method)


def _occluded_roll(width: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 37])
    behind = StagedObject(rod(rng.uniform(0.03, 0.04), 0.18), (0.0, 0.04, 0.0), colour=RED)
    return _behind_a_bar(behind, width, rng, seed, method)


def _behind_a_bar(
    behind: StagedObject, width: float, rng: np.random.Generator, seed: int, method: SegmentCallable
) -> Trial:
    # Tall enough to hide the far edge of what stands behind, seen from 32° above.
    bar = StagedObject(box(width * MM, 0.015, 0.19), (0.0, -0.06, 0.0), colour=BLUE)
    view = view_around(rng, (24, 32), turn=6.0, target=(0.0, 0.0, 0.06))
    return try_scene(method, StagedScene((behind, bar), view), seed)


def _border(share: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 41])
    objects = (
        StagedObject(box(*rng.uniform(0.06, 0.1, 3)), yaw=rng.uniform(0, np.pi), colour=RED),
        StagedObject(cylinder(0.035, 0.07), (0.18, 0.22, 0.0), colour=BLUE),
    )
    scene = StagedScene(objects, view_around(rng, turn=10.0))
    rows, columns = np.nonzero(render_staged(scene, colour=False).labels == 1)
    # Every other scene loses its object through the lower border, the rest through the left one.
    if seed % 2:
        down = scene.view.image_size[1] - 1 - np.quantile(rows, 1 - share / 100)
        shift = (0.0, float(np.round(down)))
    else:
        shift = (-float(np.round(np.quantile(columns, share / 100))), 0.0)
    if share == 0:
        shift = (0.0, 0.0)
    return try_scene(method, replace(scene, view=replace(scene.view, shift=shift)), seed)
