"""Choose the best grasps that differ from one another, and what forbids to execute them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from .grasp import Grasp
from .scoring import BRIDGED_TERM, GRAVITY, success_probability

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene

    from ..hands import ParallelHand
    from .options import JawOptions
    from .scored import ScoredCandidates
    from .surface_model import ObjectSurface

MIN_PROBABILITY = 0.02
"""Candidates below are rejected."""
MAX_SIDE_ANGLE = np.pi / 3
"""A hand that approaches at a larger angle from straight down lifts the object upwards."""
SAFE_HIDDEN = 0.5
"""Share of a fingertip in hidden space above which a grasp is not safe."""
SAFE_DEPTH = 0.003
"""Depth of readings or walls inside the hand above which a grasp is not safe, m."""
SAFE_CLEARANCE = 0.3
"""Probability of touching nothing below which a grasp is not safe."""
DENSE = 1000.0
"""Density at which an object must not exceed the friction of the pads, kg/m³: full of water."""
SAFE_WIDTH, SAFE_ROOM = 0.841, 0.005
"""Probability that the object fits the stroke below which a grasp is not safe: its width with one
standard deviation must fit. The room between pads and object must not be smaller either, m."""

WRONG_FRAME = {
    "camera": "the intrinsics of the camera are implausible",
    "pose": "the pose of the camera is implausible",
    "support_tilted": "the support is tilted in the world",
}
"""Warnings of a scene whose positions are probably wrong, and what they forbid."""


def ranked_grasps(
    scored: ScoredCandidates,
    surfaces: Sequence[ObjectSurface],
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions,
) -> list[Grasp]:
    """Return the candidates as grasps, the most probable first."""
    if len(scored.candidates) == 0:
        return []
    matrices = np.tile(np.eye(4), (len(scored.candidates), 1, 1))
    matrices[:, :3, :3] = scored.candidates.rotation
    approach = scored.candidates.rotation[:, :, 2]
    matrices[:, :3, 3] = scored.candidates.tip + scored.deeper[:, None] * approach
    # One call for all poses: each would take 0.3 ms.
    poses = RigidTransform.from_matrix(matrices)
    success = success_probability(scored.terms)
    doubtful = {one.label for one in scene.warnings if one.kind == "may_be_several"}
    return [
        _grasp(
            scored,
            index,
            poses[index],
            float(success[index]),
            surfaces[int(scored.candidates.object[index])],
            _forbidden(scored, index, surfaces, scene, hand, options),
            up_direction(scene),
            doubtful,
        )
        for index in np.argsort(-success, kind="stable")
    ]


def _forbidden(
    scored: ScoredCandidates,
    index: int,
    surfaces: Sequence[ObjectSurface],
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions,
) -> tuple[str, ...]:
    """Return what forbids to execute a grasp."""
    surface = surfaces[int(scored.candidates.object[index])]
    width = float(scored.contact.width[index])
    found = []
    if scored.terms["width"][index] < SAFE_WIDTH or width > hand.stroke - SAFE_ROOM:
        stroke = f"{1e3 * hand.stroke:.0f} mm"
        found.append(f"{1e3 * width:.0f} mm wide, may not fit the stroke of {stroke}")
    if surface.boxed:
        found.append("no solid was fitted")
    elif scored.terms["object"][index] <= BRIDGED_TERM:
        found.append("the object was not seen between the pads")
    if scored.hidden[index].max() > SAFE_HIDDEN:
        own = scored.terms["behind"][index] < 1.0
        whose = "the object or another one" if own else "another object"
        found.append(f"a finger enters space that {whose} hides")
    free = scored.terms["clearance"][index] * scored.terms["own_clearance"][index]
    depths = -scored.clearance[index]
    for depth, what in zip(depths, ("the object", "a neighbour or a wall"), strict=True):
        if depth > SAFE_DEPTH:
            found.append(f"{what} reaches {1e3 * depth:.0f} mm into the hand")
    if free < SAFE_CLEARANCE and depths.max() <= SAFE_DEPTH:
        found.append("the hand probably touches something on its way")
    load, grip = DENSE * surface.volume * GRAVITY, 2.0 * options.friction * hand.force[1]
    if load > grip:
        found.append(f"may weigh {load:.0f} N, the pads hold {grip:.0f} N")
    if any(one.kind == "cut_by_image" and one.label == surface.label for one in scene.warnings):
        found.append("the border of the image cuts the object off")
    if scene.support is None:
        found.append("no support was found")
    kinds = {warning.kind for warning in scene.warnings}
    if scene.support is not None and "support_doubtful" in kinds:
        found.append("the support is doubtful")
    for kind, what in WRONG_FRAME.items():
        if kind in kinds and not (kind == "support_tilted" and options.inclined):
            found.append(what)
    if "support_unseen" in kinds:
        found.append("something in front of the support stands on a surface that was not found")
    return tuple(found)


def _grasp(
    scored: ScoredCandidates,
    index: int,
    pose: RigidTransform,
    success: float,
    surface: ObjectSurface,
    forbidden: tuple[str, ...],
    up: NDArray[np.float64],
    doubtful: Collection[int | None],
) -> Grasp:
    """Return the grasp of a candidate; `doubtful` are the objects that may be several."""
    approach = scored.candidates.rotation[index][:, 2]
    angle = float(np.arccos(np.clip(-approach @ up, -1.0, 1.0)))
    width = float(scored.contact.width[index])
    kind = "from above" if angle < 0.5 else "from the side" if angle > 1.1 else "oblique"
    terms = {name: float(term[index]) for name, term in scored.terms.items()}
    deeper = float(scored.deeper[index])
    until = f", up to {1e3 * deeper:.0f} mm deeper until contact" if deeper else ""
    doubt = " (may be more or less than one)" if surface.label in doubtful else ""
    return Grasp(
        T_scene_tcp=pose,
        width=float(scored.opening[index]),
        retreat_direction=-approach if angle <= MAX_SIDE_ANGLE else up,
        object_label=surface.label,
        object_width=width,
        success=success,
        terms=terms,
        reason=f"object {surface.label}{doubt}, {1e3 * width:.0f} mm wide, {kind}{until}",
        object_size=surface.size,
        safe=not forbidden,
        forbidden_by=forbidden,
    )


def up_direction(scene: Scene) -> NDArray[np.float64]:
    """Return the direction up: the support's normal, or the frame's."""
    if scene.support is not None:
        return scene.support.normal
    return np.array([0.0, 0.0, 1.0]) if scene.reference_frame == "world" else np.array([0, -1.0, 0])
