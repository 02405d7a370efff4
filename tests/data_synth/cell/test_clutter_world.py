"""The floating gripper and the scenes of the clutter-removal protocol."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.cell import ClutterWorld, camera_pose, execute_grasp, make_clutter
from eyehand.data_synth.scenes import PieceObject
from eyehand.grasping import generic_jaw, load_hand

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)
DOWN = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))


def block(x, y, z, mass=0.1) -> PieceObject:
    corners = 0.5 * CORNERS * [x, y, z]
    return PieceObject("block", corners, FACES, (corners,), mass)


def world_with(item: PieceObject, hand=None) -> ClutterWorld:
    world = ClutterWorld([item], hand or load_hand("panda"), force=20.0)
    height = 0.5 * float(np.ptp(item.vertices[:, 2]))
    world.place(0, RigidTransform.from_translation([0.0, 0.0, height + 1e-4]))
    world.rest_and_remove()
    return world


def test_block_is_lifted_and_removed():
    world = world_with(block(0.05, 0.05, 0.08))
    course = execute_grasp(world, RigidTransform.from_components([0.0, 0.0, 0.05], DOWN))
    assert course.success
    assert course.removed == 0
    assert course.touched == (0,)
    assert course.closed_width == pytest.approx(0.05, abs=1e-3)
    assert course.stopped_by is None
    assert world.count == 0


def test_wide_hand_closes_on_a_thin_block():
    world = world_with(block(0.02, 0.05, 0.08), generic_jaw(stroke=0.16, finger_depth=0.06))
    course = execute_grasp(world, RigidTransform.from_components([0.0, 0.0, 0.05], DOWN))
    assert course.closed_width == pytest.approx(0.02, abs=1e-3)
    assert course.success


def test_hand_beside_the_block_closes_on_nothing():
    world = world_with(block(0.05, 0.05, 0.08))
    course = execute_grasp(world, RigidTransform.from_components([0.12, 0.0, 0.05], DOWN))
    assert not course.success
    assert course.final_width < 1e-3
    assert world.count == 1


def test_contact_before_the_approach_is_a_failure():
    world = world_with(block(0.05, 0.05, 0.15))
    course = execute_grasp(world, RigidTransform.from_components([0.04, 0.0, 0.05], DOWN))
    assert course.at_start
    assert not course.success


def test_table_stops_the_approach():
    world = world_with(block(0.05, 0.05, 0.02))
    course = execute_grasp(world, RigidTransform.from_components([0.0, 0.0, -0.02], DOWN))
    assert course.stopped_by == -1
    assert course.stopped_before == pytest.approx(0.02, abs=3e-3)


def test_block_beyond_the_friction_of_the_pads_slips():
    world = world_with(block(0.05, 0.05, 0.08, mass=6.0))
    assert not execute_grasp(world, RigidTransform.from_components([0.0, 0.0, 0.05], DOWN)).success


@pytest.mark.parametrize("family", ["packed", "pile"])
def test_scenes_depend_on_the_seed_only(family):
    objects = [block(0.05, 0.05, 0.08), block(0.03, 0.06, 0.1)]
    worlds = [
        make_clutter(family, objects, load_hand("panda"), np.random.default_rng(3))
        for _ in range(2)
    ]
    assert worlds[0].placed == worlds[1].placed
    assert 1 <= worlds[0].count <= 5
    for number in worlds[0].placed:
        a, b = (world.pose(number).as_matrix() for world in worlds)
        np.testing.assert_array_equal(a, b)
        assert worlds[0].vertices(number)[:, 2].min() > -1e-3


def test_camera_is_where_the_protocol_has_it():
    pose = camera_pose()
    ray = pose.as_matrix()[:3, 2]
    assert np.degrees(np.arccos(-ray[2])) == pytest.approx(60.0)
    target = pose.translation + 0.6 * ray
    np.testing.assert_allclose(target, [0.0, 0.0, 0.05], atol=1e-9)
