"""The trials of a fit stress test, and their criteria."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.perception import FitOptions, Superquadric, fit_superquadric
from eyehand.perception.superquadric import mesh

from ...bench import Trial
from .baselines import Fitter
from .fit_answer import FitAnswer
from .score import overlap
from .stress_views import CloudView

RIGHT = 0.75
"""IoU from which a fit is right: a hand can close around such a solid without early contact."""
MAX_SECONDS = 2.0
"""A longer fit is an invalid answer: the robot would wait."""
FOLLOW_TOLERANCE = 1e-5
"""Tolerance of a solid that must move with its cloud, as a share of its size."""
SLACK, SLACK_SHARE = 0.01, 0.25
"""Tolerance of a solid beyond points that belong to no solid, m, and share of their extent."""
LENGTHS = ("noise", "silhouette_margin", "plane_scale")
"""Options that are lengths, m. The range of semi-axes is one too."""


FitCallable = Callable[[CloudView], FitAnswer]
"""A fit under test: view → solid or reason."""


def fit_method(view: CloudView) -> FitAnswer:
    """Fit with our own fit at its default options."""
    options = FitOptions()
    low, high = options.axis_range
    lengths = {name: getattr(options, name) / view.unit for name in LENGTHS}
    lengths["silhouette_margin"] += view.margin
    options = replace(options, axis_range=(low / view.unit, high / view.unit), **lengths)
    fit = fit_superquadric(
        view.points,
        view_origin=view.view_origin,
        support_plane=view.support_plane,
        free_space=view.free_space,
        options=options,
    )
    return FitAnswer.of(fit)


def baseline_method(baseline: Fitter) -> FitCallable:
    """Return a baseline as a fit under test."""
    return lambda view: FitAnswer.of(baseline(view.points, view.view_origin, view.support_plane))


def try_fit(method: FitCallable, view: CloudView, seed: int) -> Trial:
    """Fit a view. Right: a solid with an IoU of RIGHT or more."""
    answer, seconds, fault = timed_fit(method, view)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds)
    if answer.reason:
        return Trial(False, f"refused: {answer.reason}", seconds=seconds, refused=True)
    assert view.truth is not None
    iou = overlap(view.truth, answer.parts, seed)
    right = iou >= RIGHT
    note = "" if right else f"{answer.parts[0].kind} with IoU {100 * iou:.0f} %"
    return Trial(right, note, score=iou, seconds=seconds)


def try_refusal(method: FitCallable, view: CloudView, words: str) -> Trial:
    """Fit a view that must be refused. Right: a reason that contains `words`."""
    answer, seconds, fault = timed_fit(method, view)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds)
    if answer.reason:
        named = words in answer.reason
        note = "" if named else f"refused, but: {answer.reason}"
        return Trial(named, note, seconds=seconds, refused=True)
    return Trial(False, f"not refused: {outline(answer.parts)}", seconds=seconds)


def try_stated_doubt(method: FitCallable, view: CloudView, seed: int) -> Trial:
    """Fit a difficult view. Right: an accurate solid, a refusal, or a wrong solid with a doubt.

    A wrong solid with a doubt has no score, because it is no silent failure.
    """
    doubts: list[bool] = []

    def remember(given: CloudView) -> FitAnswer:
        answer = method(given)
        doubts.append(answer.doubted)
        return answer

    trial = try_fit(remember, view, seed)
    if not trial.clean or trial.passed:
        return trial
    if trial.refused:
        return replace(trial, passed=True)
    if doubts[-1]:
        return replace(trial, passed=True, score=None, note=f"doubted: {trial.note}")
    return trial


def try_shapeless_points(method: FitCallable, view: CloudView) -> Trial:
    """Fit points of no solid. Right: a refusal, or a solid within the points.

    A solid is within the points when it exceeds them nowhere by more than SLACK plus SLACK_SHARE of
    their largest extent.
    """
    answer, seconds, fault = timed_fit(method, view)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds)
    if answer.reason:
        return Trial(True, "", seconds=seconds, refused=True)
    beyond = max(overshoot(solid, view.points) for solid in answer.parts)
    extent = float(np.ptp(view.points @ _DIRECTIONS.T, axis=0).max())
    right = beyond <= SLACK + SLACK_SHARE * extent
    note = "" if right else f"{1e3 * beyond:.0f} mm beyond the points: {outline(answer.parts)}"
    return Trial(right, note, seconds=seconds)


def try_following(
    method: FitCallable, here: CloudView, there: CloudView, T: RigidTransform, seed: int
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
    iou = None if here.truth is None else overlap(here.truth, home.parts, seed)
    if len(home.parts) != len(answer.parts):
        return Trial(False, f"{len(home.parts)} parts became {len(answer.parts)}", score=iou)
    larger = here.unit / there.unit
    expected = [_moved_solid(solid, larger, T) for solid in home.parts]
    error = max(map(surface_distance, expected, answer.parts))
    note = "" if error <= FOLLOW_TOLERANCE else f"{error:.1e} of its size off"
    return Trial(not note, note, score=iou, seconds=seconds)


def timed_fit(method: FitCallable, view: CloudView) -> tuple[FitAnswer, float, str]:
    """Fit a view; return the answer, the time in s, and the fault (empty if valid)."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        answer, seconds = _timed(method, view)
        if seconds > MAX_SECONDS:
            # The first run may have compiled a kernel.
            answer, seconds = _timed(method, view)
    fault = _fault(answer, seconds)
    if not fault and warned:
        fault = f"warned: {' '.join(str(warned[0].message).split())}"
    return answer, seconds, fault


def overshoot(solid: Superquadric, points: NDArray[np.float64]) -> float:
    """Return how far a solid exceeds the convex hull of points, m."""
    return float(np.max(solid.support(_DIRECTIONS) - (points @ _DIRECTIONS.T).max(axis=0)))


def surface_distance(first: Superquadric, second: Superquadric) -> float:
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


def _moved_solid(solid: Superquadric, larger: float, T: RigidTransform) -> Superquadric:
    """Return a solid in other units and another frame."""
    pose = RigidTransform.from_components(larger * solid.centre, solid.pose.rotation)
    return replace(solid, semi_axes=larger * solid.semi_axes, pose=T * pose)


def _timed(method: FitCallable, view: CloudView) -> tuple[FitAnswer, float]:
    began = time.perf_counter()
    answer = method(view)
    return answer, time.perf_counter() - began


def _fault(answer: FitAnswer, seconds: float) -> str:
    if seconds > MAX_SECONDS:
        return f"took {seconds:.1f} s"
    if not answer.parts and not answer.reason:
        return "neither a solid nor a reason"
    if not all(np.all(np.isfinite(solid.pose.as_matrix())) for solid in answer.parts):
        return "the solid's pose holds NaN"
    return ""
