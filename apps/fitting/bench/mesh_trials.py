"""Fits of household meshes by several methods: alone with known pixels, or found among others."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from eyehand.perception import (
    FitOptions,
    PerceiveOptions,
    Scene,
    SceneObject,
    Superquadric,
    SuperquadricFit,
    fit_region,
    perceive,
)

from ...scene_json import fit_parts
from .baselines import Fitter
from .fit_answer import FitAnswer
from .mesh_score import NOT_FOUND, MeshScore, score_mesh_fit, score_parts
from .mesh_views import MeshView, PlacedMesh

MIN_MATCH = 0.5
"""Minimum overlap of the pixels of an object and a found region for them to match."""
MIN_PIXELS = 400
"""Minimum number of visible pixels of an object among others that counts."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class MeshTrial:
    """A fit of one object by one method."""

    view: MeshView
    """The image."""
    placed: PlacedMesh
    """The object."""
    label: int
    """The object's number in the image."""
    method: str
    """Name of the method."""
    parts: tuple[Superquadric, ...]
    """The fitted solids, also of a refused fit, in the world."""
    score: MeshScore
    """The scores."""


def view_trials(
    view: MeshView, methods: Mapping[str, FitOptions], baselines: Mapping[str, Fitter]
) -> list[MeshTrial]:
    """Fit the first object of a view by all methods, with its true pixels and the true table.

    The baselines get the points of the first method.
    """
    trials: list[MeshTrial] = []
    points = np.zeros((0, 3))
    pose = view.frame.T_world_camera
    table = view.table if pose is None else view.table.moved(pose.inv())
    for name, options in methods.items():
        started = time.process_time()
        fit, points = fit_region(view.frame, view.labels, 1, table, PerceiveOptions(fit=options))
        seconds = time.process_time() - started
        trials.append(_own_trial(view, 1, name, fit, seconds))
    for name, fitter in baselines.items():
        trials.append(_baseline_trial(view, 1, name, fitter, points))
    return trials


def scene_trials(
    view: MeshView, methods: Mapping[str, FitOptions], baselines: Mapping[str, Fitter]
) -> list[MeshTrial]:
    """Perceive a view without any knowledge, and score the fit of every visible object.

    An object that no region matches counts as refused. The time is the wall time of its fit.
    """
    trials: list[MeshTrial] = []
    for index, (name, options) in enumerate(methods.items()):
        scene = perceive(view.frame, PerceiveOptions(fit=options, threads=1))
        for label in range(1, len(view.placed) + 1):
            mask = view.object_pixels == label
            if np.count_nonzero(mask) < MIN_PIXELS:
                continue
            found = _matching(scene, mask)
            fit = found.fit if found else SuperquadricFit.rejected(NOT_FOUND)
            trials.append(_own_trial(view, label, name, fit, fit.seconds))
            if index == 0:
                points = found.points if found else np.zeros((0, 3))
                trials += [
                    _baseline_trial(view, label, other, fitter, points)
                    for other, fitter in baselines.items()
                ]
    return trials


def _own_trial(
    view: MeshView, label: int, method: str, fit: SuperquadricFit, seconds: float
) -> MeshTrial:
    placed = view.placed[label - 1]
    score = score_mesh_fit(placed, fit, seconds)
    return MeshTrial(view, placed, label, method, fit_parts(fit), score)


def _baseline_trial(
    view: MeshView, label: int, method: str, fitter: Fitter, points: NDArray[np.float64]
) -> MeshTrial:
    """Fit the points with a baseline. If it raises an exception, it has no solid."""
    placed, pose = view.placed[label - 1], view.frame.T_world_camera
    plane = np.append(view.table.normal, view.table.offset)
    started = time.process_time()
    answer = FitAnswer((), NOT_FOUND)
    if len(points):
        try:
            origin = None if pose is None else np.asarray(pose.translation)
            answer = FitAnswer.of(fitter(points, origin, plane))
        except Exception as error:
            answer = FitAnswer((), f"{type(error).__name__}: {error}")
    seconds = time.process_time() - started
    score = replace(score_parts(placed, answer.usable_parts, seconds), reason=answer.reason)
    return MeshTrial(view, placed, label, method, answer.parts, score)


def _matching(scene: Scene, mask: NDArray[np.bool_]) -> SceneObject | None:
    """Return the object whose pixels overlap a mask (H, W) most, if by MIN_MATCH."""
    labels = scene.segmentation.labels
    common = np.bincount(labels[mask], minlength=scene.segmentation.count + 1)
    common[0] = 0
    label = int(np.argmax(common))
    either = np.count_nonzero(mask | (labels == label))
    if not common[label] or common[label] / either < MIN_MATCH:
        return None
    return next((item for item in scene.objects if item.label == label), None)
