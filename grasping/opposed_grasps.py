"""Grasps of fingers that oppose a thumb, planned as those of two jaws.

The prototypes of `planning` hold the fitted solid of an object across its axes. Jaws are planned on
the readings and all solids of an object, with inclined approaches and on its parts. Fingers and
thumb are such jaws: the whole row of fingers on one side, or one of them. These grasps serve
objects on which no prototype is possible.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, ndtr

from .grasp_geometry import GraspGeometry
from .hand_clearance import hand_boxes
from .hands import TENSION_PER_TIP_FORCE, GripOptions, HandBox, HandModel, ParallelHand
from .jaws import JawOptions, plan_grasps
from .jaws.clearance import COARSE_RANK, coarse_points
from .jaws.kernels import FAR, Limits, clearances
from .jaws.scoring import CLEARANCE_SIGMA, OVERLAP_MIDDLE, OVERLAP_SCALE, TOUCH_ALLOWANCE
from .jaws.surface_model import object_surface
from .palm_placement import FREE_ROOT_WIDTH, PALM_GAP, ROOT_GAP_SLOPE, max_closing_reach
from .plan import ApproachTask, GraspPlan, Score
from .prototypes import CLEARANCE, MAX_OPENING, TIGHT_CLEARANCE, Prototype, mass_range

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject

    from .jaws import Grasp
    from .jaws.point_blocks import PointBlocks
    from .jaws.surface_model import ObjectSurface

OPTIONS = JawOptions(
    depth_error=0.005, guarded=True, max_tilt=float(np.radians(30.0)), per_object=8
)
"""Options of the jaws. The arm stops when the hand touches something. With more tilt the outer
fingers of the row are too high or too low."""
PAD_HEIGHT = 0.022
"""Length of a fingertip's pad along the finger, m."""
TIP_LENGTH = 0.035
"""Length of the thin end of a finger, m."""
MAX_WIDTH = 0.123
"""Maximum width of an object between the fingertips, m."""
FALLBACK_TERM = 0.15
"""Term of all these grasps. Objects with a usual grasp go first, because they may free others."""
TIGHT_TERM = 0.9
"""Term of a grasp with the smaller opening."""
PROTOTYPE_TERMS: dict[Prototype, float] = {"precision": 1.0, "pincer": 0.6}
"""Terms of the row of fingers and of one finger."""
TABLE_GAP = 0.003
"""Minimum height of the hand above the support, m."""
NEAR_PERCENTILE = 2.0
"""Percentile of the readings along the approach that counts as the near face. Single readings are
noise."""
MIN_SCORE = 0.005
"""Minimum score of a grasp."""
TOP_COSINE = np.cos(np.radians(45.0))
"""Cosine of the angle from straight down up to which an approach is from the top."""


def plan_opposed_grasps(
    scene: Scene, hand: HandModel, labels: Collection[int]
) -> Iterator[tuple[SceneObject, GraspPlan]]:
    """Yield the objects and their grasps by opposed fingers; the score is the estimated success.

    Parameters
    ----------
    scene
        The perceived scene.
    hand
        The hand.
    labels
        Labels of the objects to grasp. The others are neighbours.
    """
    found = plan_grasps(scene, finger_jaws(hand), OPTIONS, labels)
    items = {item.label: item for item in scene.objects}
    surroundings = _Surroundings(scene)
    for grasp in found:
        item = items[grasp.object_label]
        for thumb in (1.0, -1.0):
            for prototype in PROTOTYPE_TERMS:
                best = _best_opening(_HandPose(grasp, item, hand, prototype, thumb), surroundings)
                if best.score.total >= MIN_SCORE:
                    yield item, best


def finger_jaws(hand: HandModel) -> ParallelHand:
    """Return the pinching finger and the thumb of a hand as two jaws."""
    half, row = 0.5 * hand.pinch_width, 0.5 * hand.row_width
    base = 0.5 * float(hand.outer_widths[0])
    reach = float(hand.reaches.max())
    knuckle = max(0.25 * float(np.max(hand.outer_widths - hand.openings)), hand.thickness)
    force = GripOptions().tension["precision"] / TENSION_PER_TIP_FORCE
    return ParallelHand(
        name="fingers",
        stroke=min(MAX_WIDTH, hand.max_opening),
        finger_boxes=(
            HandBox((0.0, -half, -TIP_LENGTH), (hand.thickness, half, 0.0)),
            HandBox((0.0, -half, -reach), (knuckle, half, -TIP_LENGTH)),
        ),
        finger_depth=reach - PALM_GAP,
        pad_width=hand.finger_width or hand.pinch_width,
        pad_height=PAD_HEIGHT,
        palm_boxes=(HandBox((-base, -row, -reach - hand.palm_depth), (base, row, -reach)),),
        force=(0.0, force * (len(hand.fingers) - 1)),
    )


@dataclass(frozen=True, eq=False)
class _HandPose:
    """A grasp of jaws, executed with a prototype and the thumb on one side."""

    grasp: Grasp
    item: SceneObject
    hand: HandModel
    prototype: Prototype
    thumb: float

    @cached_property
    def axes(self) -> NDArray[np.float64]:
        """Unit directions of closing, row of fingers and palm, (3, 3)."""
        palm, closing = self.grasp.approach, self.thumb * self.grasp.closing
        return np.array([closing, np.cross(palm, closing), palm])

    def near_face(self, half: float) -> float:
        """Return the place of the near face along the palm's direction, m, from the fingertips.

        ``half`` is half the width of the strip in front of the palm, m.
        """
        local = (self.item.points - self.grasp.position) @ self.axes[1:].T
        beside = np.abs(local[:, 0]) < half
        return float(np.percentile(local[beside, 1], NEAR_PERCENTILE)) if beside.any() else 0.0


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """What the open hand must not touch."""

    scene: Scene

    @cached_property
    def up(self) -> NDArray[np.float64]:
        """Unit direction up, (3,)."""
        support = self.scene.support
        return np.array([0.0, 0.0, 1.0]) if support is None else support.normal

    @cached_property
    def _surfaces(self) -> dict[int, ObjectSurface]:
        pairs = [(item.label, object_surface(item, self.scene)) for item in self.scene.objects]
        return {label: surface for label, surface in pairs if surface is not None}

    @cached_property
    def _blocks(self) -> PointBlocks:
        return coarse_points(list(self._surfaces.values()), self.scene)

    def gap(
        self, axes: NDArray[np.float64], palm: NDArray[np.float64], boxes: NDArray, label: int
    ) -> float:
        """Return the distance of boxes (B, 2, 3) in the palm's frame from all but an object, m."""
        blocks = self._blocks
        return float(
            clearances(
                np.ascontiguousarray(axes.T[None]),
                palm[None],
                np.zeros(1),
                np.array([list(self._surfaces).index(label)]),
                blocks.columns,
                blocks.label,
                np.zeros((0, 2, 3)),
                boxes,
                0.0,
                Limits(COARSE_RANK, np.full(1, -np.inf), np.array([[-np.inf, FAR]])),
            )[0, 1]
        )

    def lift(self, axes: NDArray[np.float64], palm: NDArray[np.float64], boxes: NDArray) -> float:
        """Return the height by which boxes must rise to be clear of the support, m."""
        support = self.scene.support
        if support is None:
            return 0.0
        middle, half = boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0])
        local_up = axes @ support.normal
        lowest = (middle @ local_up - half @ np.abs(local_up)).min()
        return max(TABLE_GAP - float(lowest) - float(support.height(palm[None])[0]), 0.0)


def _best_opening(pose: _HandPose, surroundings: _Surroundings) -> GraspPlan:
    """Return the better plan of a usual and a smaller opening."""
    wide = _plan(pose, CLEARANCE, surroundings)
    if wide.score.terms["room"] > TIGHT_TERM:
        return wide
    tight = _plan(pose, TIGHT_CLEARANCE, surroundings)
    return max(wide, tight, key=lambda plan: plan.score.total)


def _plan(pose: _HandPose, extra: float, surroundings: _Surroundings) -> GraspPlan:
    """Return the plan of a pose that opens by ``extra`` m more than the object is wide."""
    hand, grasp, up = pose.hand, pose.grasp, surroundings.up
    closing, row, palm = pose.axes
    width = grasp.object_width
    opening = min(width + extra, MAX_OPENING, hand.max_opening)
    reach = max_closing_reach(hand, width, opening)
    near = pose.near_face(0.5 * hand.pinch_width)
    # Neither the palm nor the roots of the fingers may touch the object.
    gap = PALM_GAP + ROOT_GAP_SLOPE * max(width - FREE_ROOT_WIDTH, 0.0)
    raised = max(gap - pose.near_face(0.5 * hand.row_width) - reach, 0.0)
    boxes = hand_boxes(hand, pose.prototype, opening, width)
    place = grasp.position - (reach + raised) * palm
    lift = surroundings.lift(pose.axes, place, boxes)
    free = surroundings.gap(pose.axes, place + lift * up, boxes, pose.item.label)
    hold = -near - raised - lift * float(-palm @ up)
    if pose.prototype != "pincer":
        # The outer fingers of an inclined row are higher and lower than the thumb.
        hold -= abs(float(row @ up)) * float(np.abs(hand.row_offsets).max(initial=0.0))
    terms = {
        "fallback": FALLBACK_TERM,
        "contacts": grasp.success,
        "prototype": PROTOTYPE_TERMS[pose.prototype],
        "opening": 1.0 if extra >= CLEARANCE else TIGHT_TERM,
        "width": 1.0 - 0.5 * width / MAX_OPENING,
        "hold": float(expit((hold - OVERLAP_MIDDLE) / OVERLAP_SCALE)),
        "room": float(ndtr((free + TOUCH_ALLOWANCE) / CLEARANCE_SIGMA)),
    }
    target = grasp.position - raised * palm + lift * up
    return GraspPlan(
        prototype=pose.prototype,
        approach="top" if -palm @ up >= TOP_COSINE else "side",
        opening=opening,
        closing=closing,
        palm=palm,
        tasks=_tasks(target, closing, palm, reach),
        score=Score(float(np.prod(list(terms.values()))), terms),
        rejected={},
        mass=mass_range(_volume(pose)),
        reason=f"{grasp.reason}: {pose.prototype}",
        geometry=_geometry(pose, target, -near, up),
        standoff=reach,
        palm_gap=near + raised + reach,
        gripped_width=width,
    )


def _volume(pose: _HandPose) -> float:
    """Return the volume of the object, m³; without a fitted solid, that of a box around it."""
    fit, size = pose.item.fit, pose.grasp.object_size
    if fit and fit.superquadric is not None:
        return sum(solid.volume for solid in fit.parts or (fit.superquadric,))
    return 0.0 if size is None else float(np.prod(size))


def _tasks(
    target: NDArray[np.float64],
    closing: NDArray[np.float64],
    palm: NDArray[np.float64],
    reach: float,
) -> tuple[ApproachTask, ...]:
    """Return the tasks that place the fingertips at a target (3,), m."""
    return (
        ApproachTask(
            "position", 3, target, palm, reach, "fingertips at the grasp", retreat_slope=1.0
        ),
        ApproachTask("orientation", 3, target, closing, 0.0, "palm and closing axis", palm=palm),
    )


def _geometry(
    pose: _HandPose, target: NDArray[np.float64], half_depth: float, up: NDArray[np.float64]
) -> GraspGeometry:
    """Return directions and sizes of the grasp for reports and for the memory of failures."""
    closing, row, palm = pose.axes
    heights = pose.item.points @ up
    solid = pose.item.fit.superquadric
    return GraspGeometry(
        kind="unknown" if solid is None else solid.kind,
        approach="top" if -palm @ up >= TOP_COSINE else "side",
        freedom="none",
        closing=closing,
        palm=palm,
        finger_row=row,
        up=up,
        centre=target,
        width=pose.grasp.object_width,
        length=float(np.ptp(pose.item.points @ row)),
        height=float(np.ptp(heights)),
        half_depth=half_depth,
        rise=float(target @ up - heights.min()),
        width_std=0.0,
    )
