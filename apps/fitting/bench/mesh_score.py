"""Fit an object of a mesh view as `perceive` does, and score the fit against the mesh."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from eyehand.perception import (
    FitOptions,
    PerceiveOptions,
    Superquadric,
    SuperquadricFit,
    fit_region,
)

from ...scene_json import fit_parts
from .fit_answer import FAILED, is_doubted
from .mesh_views import MeshView, PlacedMesh
from .score import surface_points, union_distances

DIRECTION_STEP = np.radians(10.0)
"""Angle between the closing directions that are compared, rad."""
WIDTH_STEP = np.radians(30.0)
"""Angle between the horizontal widths whose standard deviations are tested, rad."""
BOUND_SLACK = 0.002
"""Distance by which a true side may pass a stated bound, m: two standard deviations of the noise,
because the bounds come from single readings."""
MAX_WIDTH_ERROR = 0.010
"""Maximum error of the width of a usable fit, m."""
OPENING_MARGIN = 0.020
"""Opening of a gripper beyond the fitted width, m."""
NOT_FOUND = "the segmentation did not find it"
"""Reason of a refusal of an object among others that no region matches."""
PART_SAMPLES = 1 << 15
"""Points from which the volume of a union of parts is measured."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class MeshScore:
    """Scores of a fit. A rejected fit has an IoU of 0 and infinite errors."""

    iou: float
    """Intersection over union with the object, 0-1; with its convex hull if it is a vessel."""
    solid_iou: float
    """The same with the material of the object."""
    hull_iou: float
    """The same with the convex hull of the object."""
    chamfer: float
    """Mean distance of the surfaces, m. Vessels are compared by their outside."""
    width_error: float
    """Error of the width along the horizontal direction of least true width, m; signed."""
    true_width: float
    """The true width along that direction, m."""
    clears: bool
    """Whether an opening 20 mm wider than the fitted width, centred on the fit, holds the object
    between its fingers along that direction."""
    refused: bool
    """Whether the fit is falsy."""
    flagged: bool
    """Whether the fit is usable, but states a doubt."""
    parts: int
    """Number of fitted solids."""
    side_sigmas: NDArray[np.float64]
    """Errors of the sides of the fitted solid, divided by their stated standard deviations, (6,);
    empty if it is refused."""
    seconds: float
    """Processor time of the fit, s."""
    reason: str = ""
    """Why the fit was refused."""
    width_sigmas: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """Errors of six horizontal widths, divided by their stated standard deviations, (K,)."""
    in_bounds: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """Whether each true side and width lies within its stated bounds, (K,)."""

    @property
    def usable(self) -> bool:
        """Whether a grasp by the fit's width would succeed. A refused fit is not usable."""
        return not self.refused and self.clears and abs(self.width_error) <= MAX_WIDTH_ERROR

    @property
    def unsaid_iou(self) -> bool:
        """Whether the IoU is below 0.5 and the fit is neither refused nor flagged."""
        return self.iou < FAILED and not (self.refused or self.flagged)

    @property
    def unsaid_unusable(self) -> bool:
        """Whether the fit is not usable, and neither refused nor flagged."""
        return not (self.usable or self.refused or self.flagged)


def fit_view(
    view: MeshView, options: FitOptions | None = None, label: int = 1
) -> tuple[SuperquadricFit, float]:
    """Fit an object of a view with its true pixels and the true table, as `perceive` would.

    Returns
    -------
    fit, seconds
        The fit in the world frame, and the processor time that it took.
    """
    pose = view.frame.T_world_camera
    table = view.table.moved(pose.inv()) if pose is not None else None
    perceive_options = PerceiveOptions(fit=options or FitOptions())
    labels = view.labels
    started = time.process_time()
    fit, _ = fit_region(view.frame, labels, label, table, perceive_options)
    return fit, time.process_time() - started


def score_mesh_fit(placed: PlacedMesh, fit: SuperquadricFit, seconds: float = 0.0) -> MeshScore:
    """Score a fit in the world frame against the object that it stands for."""
    score = score_parts(placed, fit_parts(fit) if fit else (), seconds)
    score = replace(score, refused=not fit, flagged=is_doubted(fit), reason=fit.reason)
    return _with_extents(score, placed, fit) if fit else score


def score_parts(
    placed: PlacedMesh, parts: Sequence[Superquadric], seconds: float = 0.0
) -> MeshScore:
    """Score the union of solids in the world frame. No parts count as a refusal."""
    nothing = np.zeros(0)
    direction, low, high = least_width(placed)
    if not parts:
        return MeshScore(
            *(0.0, 0.0, 0.0, np.inf, np.inf),
            *(high - low, False, True, False, 0),
            *(nothing, seconds),
        )
    mesh = placed.mesh
    solid_iou, hull_iou = mesh_ious(placed, parts)
    fitted_high = max(float(part.support(direction)) for part in parts)
    fitted_low = -max(float(part.support(-direction)) for part in parts)
    half = OPENING_MARGIN / 2
    return MeshScore(
        iou=hull_iou if mesh.kind == "vessel" else solid_iou,
        solid_iou=solid_iou,
        hull_iou=hull_iou,
        chamfer=_chamfer(placed, parts),
        width_error=(fitted_high - fitted_low) - (high - low),
        true_width=high - low,
        clears=fitted_low - half <= low and high <= fitted_high + half,
        refused=False,
        flagged=False,
        parts=len(parts),
        side_sigmas=nothing,
        seconds=seconds,
    )


def mesh_ious(placed: PlacedMesh, parts: Sequence[Superquadric]) -> tuple[float, float]:
    """Return the IoU of a union of solids with the material of an object and with its hull."""
    mesh = placed.mesh
    samples = placed.pose.apply(mesh.samples)
    fitted = np.any([part.contains(samples) for part in parts], axis=0)
    volume = union_volume(parts)
    ious = []
    for truth in (mesh.in_material, mesh.in_hull):
        both = np.count_nonzero(fitted & truth) * mesh.sample_volume
        true_volume = np.count_nonzero(truth) * mesh.sample_volume
        ious.append(float(both / max(true_volume + volume - both, both, 1e-12)))
    return ious[0], ious[1]


def least_width(placed: PlacedMesh) -> tuple[NDArray[np.float64], float, float]:
    """Return the horizontal direction (3,) of least true width, and the object's ends along it."""
    angles = np.arange(0.0, np.pi - 1e-9, DIRECTION_STEP)
    directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    along = placed.pose.apply(placed.mesh.hull_vertices) @ directions.T
    low, high = along.min(axis=0), along.max(axis=0)
    best = int(np.argmin(high - low))
    return directions[best], float(low[best]), float(high[best])


def union_volume(parts: Sequence[Superquadric]) -> float:
    """Return the volume of a union of solids, m³."""
    if len(parts) == 1:
        return parts[0].volume
    volumes = np.array([part.volume for part in parts])
    rng = np.random.default_rng(0)
    # Points uniform in the parts, each weighted by the number of parts that contain it.
    total = 0.0
    for part, volume in zip(parts, volumes, strict=True):
        half = part.semi_axes * (1.0 + np.append(np.abs(part.taper), 0.0))
        local = half * rng.uniform(-1, 1, (PART_SAMPLES // len(parts), 3))
        points = part.to_parent(local)
        inside = points[part.contains(points)]
        if len(inside):
            counts = np.sum([other.contains(inside) for other in parts], axis=0)
            total += float(volume) * float(np.mean(1.0 / np.maximum(counts, 1)))
    return total


def _chamfer(placed: PlacedMesh, parts: Sequence[Superquadric]) -> float:
    mesh = placed.mesh
    true_points = mesh.surface_points
    if mesh.kind == "vessel":
        # The inside of a vessel lies deeper in its hull than a wall is thick.
        depth = -np.max(true_points @ mesh.hull_equations[:, :3].T + mesh.hull_equations[:, 3], 1)
        true_points = true_points[depth < np.quantile(depth, 0.5)]
    to_fit = np.abs(union_distances(placed.pose.apply(true_points), parts))
    fitted = surface_points(parts, np.random.default_rng(0))
    to_truth = mesh.distances(placed.pose.inv().apply(fitted))
    return float((to_fit.mean() + to_truth.mean()) / 2)


def _with_extents(score: MeshScore, placed: PlacedMesh, fit: SuperquadricFit) -> MeshScore:
    """Add the errors of the stated sides and widths."""
    if fit.superquadric is None:
        return score
    vertices = placed.pose.apply(placed.mesh.hull_vertices) - fit.superquadric.centre
    sides, widths, inside = [], [], []
    for side in fit.sides:
        truth = float((vertices @ side.direction).max())
        sides.append((side.position - truth) / side.sigma)
        inside.append(side.low - BOUND_SLACK <= truth <= side.high + BOUND_SLACK)
    for angle in np.arange(0.0, np.pi - 1e-9, WIDTH_STEP):
        direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        width = fit.width(direction)
        if width is not None:
            truth = float(np.ptp(vertices @ direction))
            widths.append((width.mean - truth) / width.sigma)
            inside.append(width.low - BOUND_SLACK <= truth <= width.high + BOUND_SLACK)
    return replace(
        score,
        side_sigmas=np.array(sides),
        width_sigmas=np.array(widths),
        in_bounds=np.array(inside, dtype=bool),
    )
