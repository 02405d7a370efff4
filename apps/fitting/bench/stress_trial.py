"""One try at fitting a cloud whose solid is known, and what counts as right."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception import FitOptions, Superquadric, fit_superquadric
from eyehand.perception.superquadric import mesh

from ...bench import Trial
from .score import overlap
from .stress_views import Look

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SuperquadricFit

    from .baselines import Fitter

RIGHT = 0.75
"""IoU from which a fit is right: a hand can close around such a solid without early contact."""
FAILED = 0.5
"""IoU below which a fit has failed, as in the literature. A failure without a refusal is the worst
result."""
MAX_SECONDS = 2.0
"""A longer fit is an invalid answer: the robot would wait."""
FOLLOW_TOLERANCE = 1e-5
"""Tolerance of a solid that must move with its cloud, as a share of its size."""
SLACK, SLACK_SHARE = 0.01, 0.25
"""Tolerance of a solid beyond points that belong to no solid, m, and share of their extent."""
LENGTHS = ("noise", "silhouette_margin", "plane_scale")
"""Options that are lengths, m. The range of semi-axes is one too."""


@dataclass(frozen=True)
class Answer:
    """The answer of a method to a view."""

    solids: tuple[Superquadric, ...]
    """Parts of the solid, usually one; empty without a solid."""
    reason: str
    """Why there is no solid or it must not be used; empty if it is usable."""


FitCallable = Callable[[Look], Answer]
"""A fit under test: view → solid or reason."""


def fit_method(look: Look) -> Answer:
    """Fit with our own fit at its default options."""
    options = FitOptions()
    low, high = options.axis_range
    lengths = {name: getattr(options, name) / look.unit for name in LENGTHS}
    options = replace(options, axis_range=(low / look.unit, high / look.unit), **lengths)
    fit = fit_superquadric(
        look.points,
        view_origin=look.view_origin,
        support_plane=look.support_plane,
        hidden=look.hidden,
        options=options,
    )
    return _answer(fit)


def baseline_method(baseline: Fitter) -> FitCallable:
    """Return a baseline as a fit under test."""
    return lambda look: _answer(baseline(look.points, look.view_origin, look.support_plane))


def try_fit(method: FitCallable, look: Look, seed: int) -> Trial:
    """Fit a view. Right: a solid with an IoU of RIGHT or more."""
    answer, seconds, fault = timed_fit(method, look)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds)
    if answer.reason:
        return Trial(False, f"refused: {answer.reason}", seconds=seconds, refused=True)
    assert look.truth is not None
    met = overlap(look.truth, answer.solids, seed)
    right = met >= RIGHT
    note = "" if right else f"{answer.solids[0].kind} with IoU {100 * met:.0f} %"
    return Trial(right, note, score=met, seconds=seconds)


def try_refusal(method: FitCallable, look: Look, says: str) -> Trial:
    """Fit a view that must be refused. Right: a reason that contains `says`."""
    answer, seconds, fault = timed_fit(method, look)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds)
    if answer.reason:
        named = says in answer.reason
        note = "" if named else f"refused, but: {answer.reason}"
        return Trial(named, note, seconds=seconds, refused=True)
    return Trial(False, f"not refused: {outline(answer.solids)}", seconds=seconds)


def try_no_silent_failure(method: FitCallable, look: Look, seed: int) -> Trial:
    """Fit a difficult view. Right: a refusal, or a solid that has not failed."""
    trial = try_fit(method, look, seed)
    right = trial.refused or (trial.score or 0.0) >= FAILED
    return replace(trial, passed=True, note="") if trial.clean and right else trial


def try_nothing_made_up(method: FitCallable, look: Look) -> Trial:
    """Fit points of no solid. Right: a refusal, or a solid within the points.

    A solid is within the points when it exceeds them nowhere by more than SLACK plus SLACK_SHARE of
    their largest extent.
    """
    answer, seconds, fault = timed_fit(method, look)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds)
    if answer.reason:
        return Trial(True, "", seconds=seconds, refused=True)
    beyond = max(overshoot(solid, look.points) for solid in answer.solids)
    extent = float(np.ptp(look.points @ _DIRECTIONS.T, axis=0).max())
    right = beyond <= SLACK + SLACK_SHARE * extent
    note = "" if right else f"{1e3 * beyond:.0f} mm made up: {outline(answer.solids)}"
    return Trial(right, note, seconds=seconds)


def try_following(
    method: FitCallable, here: Look, there: Look, T: RigidTransform, seed: int
) -> Trial:
    """Fit a view in two frames. Right: the same solid in both, to FOLLOW_TOLERANCE.

    `T` maps from here to there, after the change of units. If the view is of a solid, the score is
    its IoU with the solid fitted here.
    """
    home, _, fault = timed_fit(method, here)
    answer, seconds, moved_fault = timed_fit(method, there)
    if fault or moved_fault:
        return Trial(False, fault or moved_fault, clean=False, seconds=seconds)
    if home.reason or answer.reason:
        where = "both" if home.reason and answer.reason else "here" if home.reason else "there"
        note = f"refused {where}: {home.reason or answer.reason}"
        return Trial(False, note, seconds=seconds, refused=True)
    met = None if here.truth is None else overlap(here.truth, home.solids, seed)
    if len(home.solids) != len(answer.solids):
        return Trial(False, f"{len(home.solids)} parts became {len(answer.solids)}", score=met)
    larger = here.unit / there.unit
    expected = [_moved_solid(solid, larger, T) for solid in home.solids]
    off = max(map(apart, expected, answer.solids))
    note = "" if off <= FOLLOW_TOLERANCE else f"{off:.1e} of its size off"
    return Trial(not note, note, score=met, seconds=seconds)


def timed_fit(method: FitCallable, look: Look) -> tuple[Answer, float, str]:
    """Fit a view; return the answer, the time in s, and the fault (empty if valid)."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        answer, seconds = _timed(method, look)
        if seconds > MAX_SECONDS:
            # The first run may have compiled a kernel.
            answer, seconds = _timed(method, look)
    fault = _fault(answer, seconds)
    if not fault and warned:
        fault = f"warned: {' '.join(str(warned[0].message).split())}"
    return answer, seconds, fault


def overshoot(solid: Superquadric, points: NDArray[np.float64]) -> float:
    """Return how far a solid exceeds the convex hull of points, m."""
    return float(np.max(solid.support(_DIRECTIONS) - (points @ _DIRECTIONS.T).max(axis=0)))


def apart(first: Superquadric, second: Superquadric) -> float:
    """Return the distance of two surfaces, as a share of the largest semi-axis of the first.

    It is the larger of two distances: of their supports (the Hausdorff distance of convex solids),
    and of points of the first from the second, which includes concave parts.
    """
    # Relative to the centre of the first: no precision is lost far from the origin.
    between = _DIRECTIONS @ (second.centre - first.centre)
    supports = [
        solid.support(_DIRECTIONS) - _DIRECTIONS @ solid.centre for solid in (first, second)
    ]
    outer = np.abs(supports[1] - supports[0] + between).max()
    surface = first.project_radially(mesh(first, 16)[0])
    near = np.abs(second.distance(surface)).max()
    return float(max(outer, near) / first.semi_axes.max())


def outline(solids: tuple[Superquadric, ...]) -> str:
    """Describe solids: kinds with full extents."""
    return " + ".join(
        f"{solid.kind} of {' x '.join(f'{2e3 * a:.0f}' for a in solid.semi_axes)} mm"
        for solid in solids
    )


_DIRECTIONS = np.random.default_rng(0).normal(size=(500, 3))
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


def _answer(found: Superquadric | SuperquadricFit | None) -> Answer:
    if found is None:
        return Answer((), "no solid found")
    if isinstance(found, Superquadric):
        return Answer((found,), "")
    # A fit that cannot be used must say why: without a reason it counts as usable.
    return Answer(found.parts if found.superquadric is not None else (), found.reason)


def _moved_solid(solid: Superquadric, larger: float, T: RigidTransform) -> Superquadric:
    """Return a solid in other units and another frame."""
    pose = RigidTransform.from_components(larger * solid.centre, solid.pose.rotation)
    return replace(solid, semi_axes=larger * solid.semi_axes, pose=T * pose)


def _timed(method: FitCallable, look: Look) -> tuple[Answer, float]:
    began = time.perf_counter()
    answer = method(look)
    return answer, time.perf_counter() - began


def _fault(answer: Answer, seconds: float) -> str:
    if seconds > MAX_SECONDS:
        return f"took {seconds:.1f} s"
    if not answer.solids and not answer.reason:
        return "neither a solid nor a reason"
    if not all(np.all(np.isfinite(solid.pose.as_matrix())) for solid in answer.solids):
        return "the solid's pose holds NaN"
    return ""
