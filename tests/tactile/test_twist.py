"""The transformation of twists between frames."""

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
def test_adjoint_equals_conjugation_by_the_pose(pose, twist):
    T = pose.as_matrix()
    assert np.allclose(_hat(adjoint(pose) @ twist), T @ _hat(twist) @ np.linalg.inv(T), atol=1e-9)


@given(one=poses, other=poses)
def test_adjoint_of_composed_poses_is_the_product(one, other):
    assert np.allclose(adjoint(one * other), adjoint(one) @ adjoint(other), atol=1e-9)
    assert np.allclose(adjoint(one.inv()) @ adjoint(one), np.eye(6), atol=1e-9)


@given(pose=poses, twist=twists)
def test_spatial_twist_at_sensor_origin_is_the_sensor_velocity(pose, twist):
    spatial = adjoint(pose) @ twist
    sensor_twist = world_twist(pose, twist)
    assert np.allclose(
        spatial[:3] + np.cross(spatial[3:], pose.translation), sensor_twist[:3], atol=1e-9
    )
    assert np.allclose(spatial[3:], sensor_twist[3:])


def test_world_twist_agrees_with_finite_difference():
    pose = RigidTransform.from_components([0.4, -0.2, 0.7], Rotation.from_rotvec([0.3, -0.8, 1.1]))
    twist = np.array([0.02, -0.01, 0.03, 0.4, 0.2, -0.1])
    dt = 1e-6
    moved = pose * RigidTransform.from_components(
        twist[:3] * dt, Rotation.from_rotvec(twist[3:] * dt)
    )
    assert np.allclose(
        (moved.translation - pose.translation) / dt, world_twist(pose, twist)[:3], atol=1e-6
    )


def test_world_twist_rejects_invalid_poses():
    with pytest.raises(InputError, match="4 x 4"):
        world_twist(np.eye(3), np.zeros(6))
    with pytest.raises(InputError, match="right-handed"):
        world_twist(np.diag([1.0, 1.0, -1.0, 1.0]), np.zeros(6))
    with pytest.raises(InputError, match="finite"):
        world_twist(np.full((4, 4), np.nan), np.zeros(6))


def adjoint(pose):
    """Return the adjoint matrix (6, 6) of eq. (14)."""
    R, (x, y, z) = pose.rotation.as_matrix(), pose.translation
    p_hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block([[R, p_hat @ R], [np.zeros((3, 3)), R]])


def _hat(twist):
    (a, b, c), (x, y, z) = twist[:3], twist[3:]
    return np.array([[0, -z, y, a], [z, 0, -x, b], [-y, x, 0, c], [0, 0, 0, 0]])
