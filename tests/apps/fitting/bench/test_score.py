"""Scores of fits with known exact values."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.bench.odd_solids import Capsule, HalfBall, PosedSolid, Prism
from eyehand.apps.fitting.bench.score import extent_errors, overlap, score_fit, surface_distances
from eyehand.perception import Superquadric

CUBE = Prism(((-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)), 0.05, upright=True)


def cube(x: float = 0.0, turn: float = 0.0) -> PosedSolid:
    """Return a cube with edges of 0.1 m, moved along x, m, and rotated about z, rad."""
    rotation = Rotation.from_rotvec([0.0, 0.0, turn])
    return PosedSolid(CUBE, RigidTransform.from_components([x, 0.0, 0.0], rotation))


def box(x: float, a1: float = 0.05) -> Superquadric:
    """Return a box with the sharpest exponents, 2 a1 x 0.1 x 0.1 m, moved along x."""
    pose = RigidTransform.from_translation([x, 0.0, 0.0])
    return Superquadric(np.array([a1, 0.05, 0.05]), (0.02, 0.02), pose, "box")


@pytest.mark.parametrize(
    ("shift", "expected"), [(0.0, 1.0), (0.001, 0.99 / 1.01), (0.05, 1 / 3), (0.2, 0.0)]
)
def test_overlap_of_shifted_cubes(shift, expected):
    assert overlap(cube(), [cube(shift)]) == pytest.approx(expected, abs=1e-3)
    assert overlap(cube(shift, np.pi / 2), [cube()]) == pytest.approx(expected, abs=1e-3)


@settings(max_examples=30, deadline=None)
@given(
    share=st.floats(0.97, 1.0),
    exponents=st.tuples(st.floats(0.1, 1.5), st.floats(0.1, 1.5)),
    seed=st.integers(0, 1000),
)
def test_iou_of_a_smaller_solid_is_the_ratio_of_volumes(share, exponents, seed):
    rotation = Rotation.from_quat(np.random.default_rng(seed).normal(size=4))
    pose = RigidTransform.from_components([0.1, 0.2, 0.3], rotation)
    axes = np.array([0.02, 0.05, 0.08])
    whole = Superquadric(axes, exponents, pose)
    shrunk = Superquadric(share * axes, exponents, pose)
    # Four standard errors where they are largest, at 0.91.
    assert overlap(whole, [shrunk], seed) == pytest.approx(share**3, abs=0.006)


def test_iou_near_one_is_accurate_to_half_a_per_mille():
    errors = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        pose = RigidTransform.from_rotation(Rotation.from_quat(rng.normal(size=4)))
        axes, share = rng.uniform(0.015, 0.08, 3), 0.998 ** (1 / 3)
        solid = Superquadric(axes, (0.3, 1.0), pose)
        small = Superquadric(share * axes, (0.3, 1.0), pose)
        errors.append(overlap(solid, [small], seed) - 0.998)
    assert np.sqrt(np.mean(np.square(errors))) < 5e-4


def test_iou_of_a_union_counts_common_volume_once():
    halves = [box(-0.025, 0.025), box(0.025, 0.025)]
    assert overlap(cube(), halves) == pytest.approx(1.0, abs=2e-3)
    assert overlap(cube(), [*halves, box(0.0)]) == pytest.approx(1.0, abs=2e-3)
    assert overlap(cube(), halves[:1]) == pytest.approx(0.5, abs=2e-3)


def test_missing_solid_gets_worst_scores():
    score = score_fit(cube(), [])
    assert score.iou == 0.0
    assert np.isinf([score.mean_distance, score.max_distance, score.extent_error]).all()


def test_distances_of_shifted_cubes():
    # Two of six faces are 2 mm away. The others coincide except for their rims.
    mean, largest = surface_distances(cube(), [cube(0.002)])
    assert largest == pytest.approx(0.002, rel=0.01)
    assert mean == pytest.approx(0.002 / 3, rel=0.1)


def test_distances_of_concentric_balls():
    def ball(radius: float) -> Superquadric:
        pose = RigidTransform.from_translation([5.0, -3.0, 2.0])
        return Superquadric(np.full(3, radius), (1.0, 1.0), pose, "sphere")

    mean, largest = surface_distances(ball(0.05), [ball(0.04)])
    assert mean == pytest.approx(0.01, rel=0.01)
    assert largest == pytest.approx(0.01, rel=0.01)


def test_distances_to_a_union_ignore_touching_faces():
    mean, largest = surface_distances(cube(), [box(-0.025, 0.025), box(0.025, 0.025)])
    assert mean < 1e-4
    # Even the sharpest superquadric has slightly rounded corners.
    assert largest < 3e-3


def test_protruding_part_sets_maximum_distance():
    pose = RigidTransform.from_translation([0.045, 0.0, 0.0])
    ball = Superquadric(np.full(3, 0.02), (1.0, 1.0), pose, "sphere")
    mean, largest = surface_distances(cube(), [cube(), ball])
    assert largest == pytest.approx(0.015, rel=0.05)
    assert 0 < mean < 0.002


def test_extent_errors_are_along_the_true_axes():
    error, share = extent_errors(cube(0.3, 0.4), [cube(-0.1, 0.4)])
    assert (error, share) == pytest.approx((0.0, 0.0), abs=1e-12)
    # Rotated by 45°, a square has a √2 times larger extent.
    error, share = extent_errors(cube(), [cube(0.0, np.pi / 4)])
    assert error == pytest.approx(0.05 * (np.sqrt(2) - 1))
    assert share == pytest.approx(np.sqrt(2) - 1)
    error, share = extent_errors(box(0.0, 0.02), [box(0.0, 0.023)])
    assert error == pytest.approx(0.003)
    assert share == pytest.approx(0.15)


def test_extents_of_a_solid_and_its_dual_agree():
    square = Superquadric(np.array([0.04, 0.04, 0.03]), (0.1, 0.02), RigidTransform.identity())
    turn = RigidTransform.from_rotation(Rotation.from_rotvec([0.0, 0.0, np.pi / 4]))
    diamond = Superquadric(np.array([0.04, 0.04, 0.03]) * [2**0.5, 2**0.5, 1], (0.1, 1.98), turn)
    assert extent_errors(square, [diamond])[1] < 0.03


def test_extents_of_round_shapes():
    place = RigidTransform.from_translation([0.0, 0.1, 0.0])
    capsule, half = PosedSolid(Capsule(0.02, 0.03), place), PosedSolid(HalfBall(0.05), place)
    assert capsule.support(np.eye(3)) == pytest.approx([0.05, 0.12, 0.02], abs=1e-4)
    assert half.support(np.eye(3)) == pytest.approx([0.05, 0.15, 0.025], abs=1e-4)
    assert extent_errors(capsule, [capsule, half])[0] == pytest.approx(0.03, abs=1e-4)
