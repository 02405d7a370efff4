"""Choose the best grasps that differ from one another, and what forbids to execute them."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from .grasp import Grasp
from .scoring import GRAVITY, success_probability
from .symmetry import is_turned, symmetry_axes

if TYPE_CHECKING:
    from collections.abc import Sequence

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
SAME_DISTANCE, SAME_ANGLE = 0.012, np.radians(25.0)
"""Two grasps that differ by less are one, m and rad."""
SAFE_HIDDEN = 0.5
"""Share of a fingertip in hidden space above which a grasp is not safe."""
SAFE_DEPTH = 0.003
"""Depth of readings or walls inside the hand above which a grasp is not safe, m."""
SAFE_CLEARANCE = 0.3
"""Probability of touching nothing below which a grasp is not safe."""
DENSE = 1000.0
"""Density at which an object must not exceed the friction of the pads, kg/m³: full of water."""
SAFE_WIDTH_SHARE = 0.92
"""A wider object is gripped at the limit of the stroke: 73 mm for a jaw of 80 mm."""


def select_grasps(
    scored: ScoredCandidates,
    hidden: NDArray[np.float64],
    surfaces: Sequence[ObjectSurface],
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions,
) -> list[Grasp]:
    """Return the best grasps that differ from one another."""
    total = scored.total
    order = np.argsort(-total, kind="stable")
    chosen: list[int] = []
    count: Counter[int] = Counter()
    axes = [symmetry_axes(surface) for surface in surfaces]
    tips, rotations = scored.candidates.tip, scored.candidates.rotation
    for index in order:
        number = int(scored.candidates.object[index])
        if total[index] < MIN_PROBABILITY:
            break
        if count[number] >= options.per_object:
            continue
        if not any(
            scored.candidates.object[other] == number
            and (
                _same(tips[index], tips[other], rotations[index], rotations[other])
                or is_turned(
                    axes[number], tips[index], tips[other], rotations[index], rotations[other]
                )
            )
            for other in chosen
        ):
            chosen.append(int(index))
            count[number] += 1
    matrices = np.tile(np.eye(4), (len(chosen), 1, 1))
    matrices[:, :3, :3], matrices[:, :3, 3] = rotations[chosen], tips[chosen]
    # One call for all poses: each would take 0.3 ms.
    poses = RigidTransform.from_matrix(matrices) if chosen else ()
    return [
        _grasp(
            scored,
            index,
            pose,
            surfaces[int(scored.candidates.object[index])],
            _forbidden(scored, index, hidden[index], surfaces, scene, hand, options),
            up_direction(scene),
        )
        for index, pose in zip(chosen, poses, strict=True)
    ]


def _forbidden(
    scored: ScoredCandidates,
    index: int,
    hidden: NDArray[np.float64],
    surfaces: Sequence[ObjectSurface],
    scene: Scene,
    hand: ParallelHand,
    options: JawOptions,
) -> tuple[str, ...]:
    """Return what forbids to execute a grasp."""
    surface = surfaces[int(scored.candidates.object[index])]
    width = float(scored.contact.width[index])
    found = []
    if width > SAFE_WIDTH_SHARE * hand.stroke:
        found.append(f"{1e3 * width:.0f} mm wide, the hand opens {1e3 * hand.stroke:.0f} mm")
    if not surface.fitted:
        found.append("no solid was fitted")
    if hidden.max() > SAFE_HIDDEN:
        found.append("a finger enters space that another object hides")
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
    elif any(warning.kind == "support_doubtful" for warning in scene.warnings):
        found.append("the support is doubtful")
    return tuple(found)


def _same(
    tip: NDArray[np.float64],
    other: NDArray[np.float64],
    rotation: NDArray[np.float64],
    turned: NDArray[np.float64],
) -> bool:
    if np.linalg.norm(tip - other) > SAME_DISTANCE:
        return False
    limit = np.cos(SAME_ANGLE)
    closing = abs(float(rotation[:, 0] @ turned[:, 0]))
    return closing > limit and float(rotation[:, 2] @ turned[:, 2]) > limit


def _grasp(
    scored: ScoredCandidates,
    index: int,
    pose: RigidTransform,
    surface: ObjectSurface,
    forbidden: tuple[str, ...],
    up: NDArray[np.float64],
) -> Grasp:
    """Return the grasp of a candidate."""
    approach = scored.candidates.rotation[index][:, 2]
    angle = float(np.arccos(np.clip(-approach @ up, -1.0, 1.0)))
    width = float(scored.contact.width[index])
    kind = "from above" if angle < 0.5 else "from the side" if angle > 1.1 else "oblique"
    terms = {name: float(term[index]) for name, term in scored.terms.items()}
    return Grasp(
        T_scene_tcp=pose,
        width=float(scored.opening[index]),
        retreat_direction=-approach if angle <= MAX_SIDE_ANGLE else up,
        object_label=surface.label,
        object_width=width,
        success=success_probability(float(np.prod(list(terms.values())))),
        terms=terms,
        reason=f"object {surface.label}, {1e3 * width:.0f} mm wide, {kind}",
        object_size=surface.size,
        safe=not forbidden,
        forbidden_by=forbidden,
    )


def up_direction(scene: Scene) -> NDArray[np.float64]:
    """Return the direction up: the support's normal, or the frame's."""
    if scene.support is not None:
        return scene.support.normal
    return np.array([0.0, 0.0, 1.0]) if scene.reference_frame == "world" else np.array([0, -1.0, 0])
