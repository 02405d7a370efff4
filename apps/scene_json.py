"""Plain data of scenes, solids and fits for JSON files: SI units, quaternions as w, x, y, z."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.perception.superquadric import PARAMETERS, CandidateSolid, SideEstimate, Vessel

if TYPE_CHECKING:
    from eyehand.grasping import GraspPlan
    from eyehand.perception import (
        Container,
        Scene,
        SceneObject,
        Superquadric,
        SuperquadricFit,
        SupportPlane,
    )

SCENE_SCHEMA = "eyehand.scene/1"
UNITS = {"length": "m", "angle": "rad", "mass": "kg", "time": "s", "quaternion": "wxyz"}
PARAMETER_UNITS = {
    **dict.fromkeys(("a1", "a2", "a3"), "m"),
    **dict.fromkeys(("eps1", "eps2"), "1"),
    **dict.fromkeys(("rx", "ry", "rz"), "rad"),
    **dict.fromkeys(("cx", "cy", "cz"), "m"),
    **dict.fromkeys(("k1", "k2"), "1"),
}
"""Units of the rows and columns of a covariance: semi-axes, exponents, rotation about the local
axes, centre in the frame of the cloud, taper."""


def scene_json(scene: Scene, plans: dict[int, GraspPlan], source: str) -> dict[str, Any]:
    """Return a scene with its grasp plans as plain data. Every number is finite."""
    support = scene.support
    return {
        "schema": SCENE_SCHEMA,
        "units": UNITS,
        "source": source,
        "frame": scene.reference_frame,
        "labels": "labels.png",
        "support_plane": None if support is None else _plane(support),
        "objects": [_object(item, plans[item.label]) for item in scene.objects],
        "containers": [_container(one) for one in scene.containers],
        "unknown_regions": [
            {
                "outline_px": [_numbers(corner) for corner in one.outline],
                "corners_m": [_numbers(corner) for corner in one.corners],
                "height_m": _number(one.height),
            }
            for one in scene.unknown
        ],
        "warnings": [
            {"kind": one.kind, "message": one.message, "object": one.label}
            for one in scene.warnings
        ],
        "timings_s": {stage: _number(value) for stage, value in scene.timings.items()},
    }


def solid_json(solid: Superquadric) -> dict[str, Any]:
    """Return a solid as plain data."""
    return {
        "kind": solid.kind,
        "semi_axes_m": _numbers(solid.semi_axes),
        "exponents": [_number(e) for e in solid.exponents],
        "taper": [_number(k) for k in solid.taper],
        "position_m": _numbers(solid.centre),
        "quat_wxyz": _numbers(solid.pose.rotation.as_quat(scalar_first=True)),
        "volume_m3": float(f"{solid.volume:.6g}"),
    }


def vessel_json(vessel: Vessel) -> dict[str, Any]:
    """Return what a vessel has besides its outer solid, which is the solid of the fit.

    The rim is the ellipse ``centre ± semi-axis · direction``. The wall is None if the view does not
    resolve it. The volume is that of wall and floor. The opening of a ring goes through.
    """
    return {
        "rim": {
            "centre_m": _numbers(vessel.rim.centre),
            "semi_axes_m": _numbers(vessel.rim.semi_axes),
            "directions": [_numbers(direction) for direction in vessel.rim.directions],
        },
        "opening_direction": _numbers(vessel.opening),
        "through": vessel.through,
        "wall_m": None if vessel.wall is None else _number(vessel.wall),
        "volume_m3": float(f"{vessel.volume:.6g}"),
    }


def fit_json(fit: SuperquadricFit) -> dict[str, Any]:
    """Return a fit as plain data, with its parts, uncertainty and candidate models.

    Every number is finite.
    """
    return {
        "converged": fit.converged,
        "reason": fit.reason,
        "spread_m": _number(fit.spread) if fit.residuals.size else None,
        "solid": None if fit.superquadric is None else solid_json(fit.superquadric),
        "vessel": None if fit.vessel is None else vessel_json(fit.vessel),
        "parts": [solid_json(part) for part in fit_parts(fit)],
        "uncertainty": _uncertainty(fit),
        "sides": [_side(side) for side in fit.sides],
        "runner_up": None if fit.runner_up is None else _candidate(fit.runner_up),
        "margin": _number(fit.margin) if math.isfinite(fit.margin) else None,
        "ambiguous": fit.ambiguous,
        "outline_differs": fit.outline_differs,
        "width_uncertain": fit.width_uncertain,
        "covered_share": _number(fit.covered_share),
        "missed_share": _number(fit.missed_share),
        "alternatives": [_candidate(c) for c in fit.alternatives],
        "ladder": [
            {"kind": c.kind, "spread_m": _number(c.spread), "criterion": _number(c.criterion)}
            for c in fit.candidates
        ],
        "time_s": _number(fit.seconds),
    }


def fit_parts(fit: SuperquadricFit) -> tuple[Superquadric, ...]:
    """Return the solids of a fit, largest first, or none if the fit failed."""
    if fit.superquadric is None:
        return ()
    return fit.parts or (fit.superquadric,)


def _candidate(candidate: CandidateSolid) -> dict[str, Any]:
    return {
        "kind": candidate.kind,
        "spread_m": _number(candidate.spread),
        "criterion": _number(candidate.criterion),
        "solid": solid_json(candidate.superquadric),
    }


def _uncertainty(fit: SuperquadricFit) -> dict[str, Any] | None:
    known, covariance = fit.uncertainty, fit.covariance
    if known is None or covariance is None:
        return None
    return {
        "parameters": list(PARAMETERS),
        "units": [PARAMETER_UNITS[name] for name in PARAMETERS],
        "covariance": [[float(f"{value:.6g}") for value in row] for row in covariance],
        "unobserved_sides": list(known.unobserved),
    }


def _side(side: SideEstimate) -> dict[str, Any]:
    """Return a side; its distances are from the centre of the solid. Without a bound it is None."""
    return {
        "side": side.name,
        "direction": _numbers(side.direction),
        "position_m": _number(side.position),
        "sigma_m": _number(side.sigma),
        "low_m": _number(side.low) if math.isfinite(side.low) else None,
        "high_m": _number(side.high) if math.isfinite(side.high) else None,
    }


def _object(item: SceneObject, plan: GraspPlan) -> dict[str, Any]:
    return {
        "label": item.label,
        "pixels": item.pixel_count,
        "visible_share": _number(item.visible_share),
        "rests_on": item.rests_on,
        "overlaps": list(item.overlaps),
        "fit": fit_json(item.fit),
        "grasp": {
            "prototype": plan.prototype,
            "approach": plan.approach,
            "opening_m": _number(plan.opening),
            "closing_direction": _numbers(plan.closing),
            "palm_direction": _numbers(plan.palm),
            "task_rows": plan.rows,
            "tasks": [
                {
                    "name": task.name,
                    "rows": task.rows,
                    "point_m": _numbers(task.point),
                    "axis": _numbers(task.axis),
                    "target": _number(task.target),
                    "description": task.description,
                }
                for task in plan.tasks
            ],
            "score": _number(plan.score.total),
            "score_terms": {name: _number(term) for name, term in plan.score.terms.items()},
            "mass_kg": dict(zip(("low", "likely", "high"), _numbers(plan.mass), strict=True)),
            "reason": plan.reason,
            "rejected": plan.rejected,
        },
    }


def _plane(plane: SupportPlane) -> dict[str, Any]:
    return {
        "normal": _numbers(plane.normal),
        "offset_m": _number(plane.offset),
        "tolerance_m": _number(plane.tolerance),
    }


def _container(container: Container) -> dict[str, Any]:
    return {
        "floor_plane": _plane(container.floor),
        "floor_seen": container.floor_seen,
        "rim_height_m": _number(container.rim),
        "walls": [
            {
                "corners_m": [_numbers(corner) for corner in wall.corners],
                "thickness_m": _number(wall.thickness),
                "rim_seen": wall.seen,
            }
            for wall in container.walls
        ],
    }


def _number(value: float) -> float:
    return round(float(value), 6)


def _numbers(values: Any) -> list[float]:
    return [_number(value) for value in np.asarray(values, dtype=float).ravel()]
