"""Twists change frames as rigid bodies move."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.tactile import world_twist

numbers = st.floats(-2.0, 2.0)
twists = st.lists(numbers, min_size=6, max_size=6).map(np.array)
poses = st.lists(numbers, min_size=6, max_size=6).map(
    lambda v: RigidTransform.from_components(v[:3], Rotation.from_rotvec(v[3:]))
)


@given(pose=poses, twist=twists)
def test_it_is_what_conjugating_the_pose_does_to_the_twist(pose, twist):
    T = pose.as_matrix()
    assert np.allclose(_hat(adjoint(pose) @ twist), T @ _hat(twist) @ np.linalg.inv(T), atol=1e-9)


@given(one=poses, other=poses)
def test_adjoints_of_chained_poses_multiply(one, other):
    assert np.allclose(adjoint(one * other), adjoint(one) @ adjoint(other), atol=1e-9)
    assert np.allclose(adjoint(one.inv()) @ adjoint(one), np.eye(6), atol=1e-9)


@given(pose=poses, twist=twists)
def test_the_spatial_twist_moved_to_the_sensor_is_the_sensors_own_velocity(pose, twist):
    spatial = adjoint(pose) @ twist
    here = world_twist(pose, twist)
    assert np.allclose(spatial[:3] + np.cross(spatial[3:], pose.translation), here[:3], atol=1e-9)
    assert np.allclose(spatial[3:], here[3:])


def test_the_sensors_velocity_agrees_with_a_small_motion():
    pose = RigidTransform.from_components([0.4, -0.2, 0.7], Rotation.from_rotvec([0.3, -0.8, 1.1]))
    twist = np.array([0.02, -0.01, 0.03, 0.4, 0.2, -0.1])
    dt = 1e-6
    moved = pose * RigidTransform.from_components(
        twist[:3] * dt, Rotation.from_rotvec(twist[3:] * dt)
    )
    assert np.allclose(
        (moved.translation - pose.translation) / dt, world_twist(pose, twist)[:3], atol=1e-6
    )


def test_what_is_no_pose_is_refused():
    with pytest.raises(InputError, match="4 x 4"):
        world_twist(np.eye(3), np.zeros(6))
    with pytest.raises(InputError, match="right-handed"):
        world_twist(np.diag([1.0, 1.0, -1.0, 1.0]), np.zeros(6))
    with pytest.raises(InputError, match="finite"):
        world_twist(np.full((4, 4), np.nan), np.zeros(6))


def adjoint(pose):
    """The matrix of eq. (14), (6, 6)."""
    R, (x, y, z) = pose.rotation.as_matrix(), pose.translation
    p_hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block([[R, p_hat @ R], [np.zeros((3, 3)), R]])


def _hat(twist):
    (a, b, c), (x, y, z) = twist[:3], twist[3:]
    return np.array([[0, -z, y, a], [z, 0, -x, b], [-y, x, 0, c], [0, 0, 0, 0]])
