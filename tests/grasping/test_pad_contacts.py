"""Pads that touch the solid: chords of lines, and the fingers that pass beside a thin object."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.grasping.chord_kernels import chord
from eyehand.grasping.hands import nominal_hand
from eyehand.grasping.planning import plan_prototypes
from eyehand.perception import SceneObject, Superquadric, SupportPlane
from eyehand.perception.superquadric import SuperquadricFit, sample_surface

TABLE = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)


def planned(size):
    """Return the plans for a known box of full size (3,), m, that stands on the table."""
    half = 0.5 * np.array(size)
    pose = RigidTransform.from_translation([0.0, 0.0, half[2]])
    solid = Superquadric(half, (0.1, 0.1), pose, "box")
    cloud = sample_surface(solid, 300, np.random.default_rng(0))
    fit = SuperquadricFit(solid, True, "known", np.zeros(300), (), 0.0)
    item = SceneObject(1, cloud, 300, fit, 1.0, 0)
    return [plan for plan in plan_prototypes(item, TABLE, hand=nominal_hand()) if plan]


def reference_chord(solid, start, step, length):
    """Return the chord by dense samples and root finding, or None."""
    samples = np.linspace(0.0, length, 4001)
    inside = solid.contains(start + samples[:, None] * step)
    if not inside.any():
        return None
    first, last = np.flatnonzero(inside)[[0, -1]]

    def scale(t):
        return float(solid.radial_scale(start + t * step)) - 1.0

    low: Any = brentq(scale, samples[first - 1], samples[first])
    high: Any = brentq(scale, samples[last], samples[last + 1])
    return low, high


@pytest.mark.parametrize("taper", [(0.0, 0.0), (0.3, -0.2)])
def test_chord_equals_dense_search(taper):
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(60):
        turn = Rotation.random(rng=rng)
        solid = Superquadric(
            rng.uniform(0.01, 0.05, 3),
            tuple(rng.uniform(0.1, 1.0, 2)),
            RigidTransform.from_components(rng.uniform(-0.01, 0.01, 3), turn),
            "tapered" if any(taper) else "superquadric",
            taper,
        )
        step = rng.standard_normal(3)
        step /= np.linalg.norm(step)
        start = rng.uniform(-0.03, 0.03, 3) - 0.15 * step
        expected = reference_chord(solid, start, step, 0.3)
        found = chord(
            solid.to_local(start),
            step @ solid.rotation,
            0.3,
            solid.semi_axes,
            np.array(solid.exponents),
            np.array(solid.taper),
        )
        if expected is None or expected[1] - expected[0] < 0.002:
            continue
        hits += 1
        assert found == pytest.approx(expected, abs=5e-5)
    assert hits > 15


def test_line_beside_the_solid_has_no_chord():
    sizes = np.full(3, 0.02), np.array([1.0, 1.0]), np.zeros(2)
    found = chord(np.array([-0.1, 0.021, 0.0]), np.array([1.0, 0.0, 0.0]), 0.2, *sizes)
    assert np.isnan(found).all()


def test_no_power_grasp_where_outer_fingers_pass_beside_the_box():
    plans = planned((0.060, 0.026, 0.12))
    across = [plan for plan in plans if plan.name == "top power"]
    assert not across
    assert any(plan.prototype == "precision" for plan in plans)


def test_row_of_fingers_on_a_wide_box_touches_with_all():
    plan = next(p for p in planned((0.056, 0.090, 0.12)) if p.name == "top power")
    assert plan.fingers == len(nominal_hand().row_offsets)


def test_no_top_power_grasp_where_the_palm_stays_above_a_flat_face():
    assert not [plan for plan in planned((0.070, 0.090, 0.050)) if plan.name == "top power"]
    assert [plan for plan in planned((0.070, 0.090, 0.110)) if plan.name == "top power"]
