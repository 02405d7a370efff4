"""Probability that a planned grasp holds, from contact mechanics and the errors of the fit."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from .chord_kernels import pad_chords
from .hands import TENSION_PER_TIP_FORCE, GripOptions, HandModel
from .hold_kernels import VARIATES, hold_probability
from .pad_contacts import MAX_CHORD, MIN_OVERLAP, palm_position
from .palm_placement import PalmPlacement
from .prototypes import DENSITY_RANGE, LIKELY_DENSITY, Prototype

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .grasp_geometry import GraspGeometry
    from .plan import GraspPlan

SAMPLES = 256
"""Number of samples. The standard error of a probability is at most 3 %."""
FRICTION, FRICTION_STD = 0.8, 0.15
"""Coefficient of friction of a rubber pad on household objects, and its standard deviation."""
GRAVITY, ACCELERATION = 9.81, 3.0
"""Gravity, and the acceleration of lift and carry, m/s²."""
MASS_STD = 0.5 * float(np.log(DENSITY_RANGE[1] / LIKELY_DENSITY))
"""Standard deviation of the logarithm of the mass: the range of densities is two of them."""
CENTRE_SHARE = 0.10
"""Standard deviation of the centre of mass, as a share of the object's size. Bottles are half full,
and tools have a heavy end."""
PLACE_STD = 0.003
"""Standard deviation of the hand's place relative to the object, m: calibration and control."""
SLOPE_STD = 0.10
"""Standard deviation of the surface's slope at a contact."""
SLOPE_STEP = 0.004
"""Distance along the palm's direction over which the slope is measured, m."""
MIN_DEPTH = 0.004
"""Minimum depth of the fingertips beyond the near face, m."""
PATCH_RADIUS = 0.006
"""Radius of a contact patch of a pad, m."""
CONTACT_DEPTH = 0.010
"""Distance of the contact on a pad from the fingertip, m."""
CENTRAL_OFFSET = 0.008
"""Offset along the row below which a finger is the pinching one, m."""


def hold_quality(
    solid: Superquadric,
    prototype: Prototype,
    geometry: GraspGeometry,
    placement: PalmPlacement,
    hand: HandModel,
) -> float:
    """Return the probability that a grasp resists gravity and inertia of lift and carry.

    The fingers press with equal forces, as their tendons do. Fingers of a precision grasp that pass
    beside the object do not pull. In a power grasp all of them pull, and at least two must touch.
    """
    middle = palm_position(geometry, placement)
    axes = np.array([geometry.closing, geometry.finger_row, geometry.palm])
    centre = axes @ (solid.centre - middle)
    offsets = hand.row_offsets
    if prototype == "pincer":
        offsets = offsets[np.abs(offsets) < CENTRAL_OFFSET] if len(offsets) > 1 else offsets
    reach = hand.reach(geometry.width)
    near = placement.standoff - geometry.half_depth
    # In a power grasp from the side the pads beyond the object's middle do not meet it.
    contact = min(reach - CONTACT_DEPTH, float(centre[2]) + CONTACT_DEPTH)
    slopes = _slopes(solid, axes, middle, contact, float(centre[1]))
    mass = solid.volume * LIKELY_DENSITY
    tension = GripOptions().finger_tension(prototype, len(offsets))
    force = tension / TENSION_PER_TIP_FORCE
    needed = 2 if prototype == "power" and len(offsets) > 1 else 1
    half = 0.5 * geometry.length
    return float(
        hold_probability(
            _variates(),
            offsets,
            slopes,
            np.array([centre[1] - half, centre[1] + half, reach - near, MIN_DEPTH]),
            np.array(
                [
                    float(np.hypot(PLACE_STD, geometry.width_std)),
                    float(np.hypot(PLACE_STD, geometry.width_std)),
                    SLOPE_STD,
                    MASS_STD,
                    CENTRE_SHARE * geometry.length,
                    CENTRE_SHARE * 2.0 * geometry.half_depth,
                    FRICTION_STD,
                ]
            ),
            np.array(
                [
                    mass * (GRAVITY + ACCELERATION),
                    *(-axes @ geometry.up),
                    centre[1],
                    centre[2] - contact,
                ]
            ),
            np.array(
                [
                    force,
                    0.5 * hand.pad_width,
                    0.5 * hand.pinch_width,
                    MIN_OVERLAP,
                    PATCH_RADIUS,
                    float(needed),
                ]
            ),
            FRICTION,
        )
    )


def plan_hold(plan: GraspPlan, solid: Superquadric, hand: HandModel) -> float:
    """Return the probability of :func:`hold_quality` of a plan; 0 for a refusal."""
    if plan.prototype is None or plan.geometry is None:
        return 0.0
    placement = PalmPlacement(plan.standoff, 0.0, 0.0, 0.0)
    return hold_quality(solid, plan.prototype, plan.geometry, placement, hand)


def _slopes(
    solid: Superquadric,
    axes: NDArray[np.float64],
    middle: NDArray[np.float64],
    depth: float,
    row: float,
) -> NDArray[np.float64]:
    """Return the slopes of the surface along the palm's direction at fingers and thumb, (2,).

    A slope is positive where the object becomes thinner towards the fingertips. A line that misses
    the solid has an infinite slope.
    """
    depths = depth + SLOPE_STEP * np.array([-0.5, 0.5])
    chords = pad_chords(
        np.array([row]),
        depths,
        (middle - solid.centre) @ solid.rotation,
        np.ascontiguousarray(axes @ solid.rotation),
        MAX_CHORD,
        solid.semi_axes,
        np.array(solid.exponents),
        np.array(solid.taper),
    )
    if not np.isfinite(chords).all():
        return np.full(2, np.inf)
    low, high = chords[0, :, 0], chords[0, :, 1]
    return np.array([low[1] - low[0], high[0] - high[1]]) / SLOPE_STEP


@cache
def _variates() -> NDArray[np.float64]:
    """Return fixed quasi-random normal variates, (SAMPLES, VARIATES)."""
    return np.ascontiguousarray(
        ndtri(qmc.Sobol(VARIATES, rng=np.random.default_rng(0)).random(SAMPLES))
    )
