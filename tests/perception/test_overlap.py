"""Tests of the overlap of solids of neighbouring objects."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation
from synthetic_balls import ball_frame

from eyehand.perception import Superquadric, SuperquadricFit, perceive
from eyehand.perception.overlap import overlap_depth, overlapping_objects


def ball(radius, centre):
    pose = RigidTransform.from_translation(centre)
    return Superquadric(np.full(3, radius), (1.0, 1.0), pose, "sphere")


def box(half, centre, turn=None):
    pose = RigidTransform.from_components(centre, turn or Rotation.identity())
    return Superquadric(np.array(half), (0.02, 0.02), pose, "box")


def fit_of(*parts):
    return SuperquadricFit(parts[0], True, "", np.zeros(0), (), 0.0, parts=parts)


@given(st.floats(0.01, 0.1), st.floats(0.01, 0.1), st.floats(0.0, 0.15), st.integers(0, 2**31 - 1))
def test_depth_of_balls_is_exact(first, second, distance, seed):
    towards = np.random.default_rng(seed).normal(size=3)
    towards *= distance / np.linalg.norm(towards)
    depth = overlap_depth([ball(first, np.ones(3))], [ball(second, np.ones(3) + towards)])
    assert depth == pytest.approx(max(first + second - distance, 0.0), abs=1e-9)


@given(st.integers(0, 2**31 - 1))
def test_frame_and_order_do_not_change_the_depth(seed):
    rng = np.random.default_rng(seed)
    solids = [
        Superquadric(
            rng.uniform(0.02, 0.08, 3),
            tuple(rng.uniform(0.1, 1.9, 2)),
            RigidTransform.from_components(rng.uniform(-0.05, 0.05, 3), Rotation.random(rng=rng)),
        )
        for _ in range(2)
    ]
    depth = overlap_depth(solids[:1], solids[1:])
    assert overlap_depth(solids[1:], solids[:1]) == pytest.approx(depth, rel=0.08, abs=3e-4)
    by = RigidTransform.from_components([0.3, -1.0, 2.0], Rotation.random(rng=rng))
    moved = [Superquadric(one.semi_axes, one.exponents, by * one.pose, one.kind) for one in solids]
    assert overlap_depth(moved[:1], moved[1:]) == pytest.approx(depth, rel=0.08, abs=3e-4)
    # No sampled direction separates the solids by a shorter shift.
    directions = rng.normal(size=(3000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sampled = (solids[0].support(directions) + solids[1].support(-directions)).min()
    assert depth <= max(sampled, 0.0) * 1.08 + 3e-4


def test_boxes_overlap_by_the_smallest_shift():
    table = box([0.1, 0.1, 0.02], [0, 0, 0])
    above = box([0.02, 0.02, 0.03], [0.03, 0, 0.045], Rotation.from_euler("z", 0.4))
    assert overlap_depth([table], [above]) == pytest.approx(0.005, abs=3e-4)
    assert overlap_depth([table], [box([0.02, 0.02, 0.03], [0.03, 0, 0.0501])]) < 2e-4


def test_parts_overlap_if_any_two_of_them_do():
    far = ball(0.02, [1.0, 0, 0])
    assert overlap_depth([far, ball(0.05, [0, 0, 0])], [ball(0.05, [0.09, 0, 0])]) == pytest.approx(
        0.01, abs=1e-6
    )
    assert overlap_depth([], [far]) == 0.0


def test_smaller_object_of_two_is_named():
    fits = {
        1: fit_of(ball(0.05, [0, 0, 0])),
        2: SuperquadricFit.rejected("too far"),
        3: fit_of(ball(0.03, [0.07, 0, 0])),
        4: fit_of(ball(0.03, [0.2, 0, 0])),
    }
    assert overlapping_objects(fits) == {1: (), 2: (), 3: (1,), 4: ()}


def test_separate_balls_of_a_scene_do_not_overlap():
    frame, _ = ball_frame([(-0.12, 0.62, 0.05), (0.0, 0.75, 0.04), (0.13, 0.6, 0.045)])
    assert all(item.overlaps == () for item in perceive(frame).objects)
