"""Tests of poses in JSON and as matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.io.pose_json import pose_from_json, pose_from_matrix, pose_to_json


def _identity_except(row: int, column: int, value: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[row, column] = value
    return matrix


def test_quaternion_order_is_wxyz() -> None:
    half = np.sqrt(0.5)
    pose = pose_from_json({"quat_wxyz": [half, 0, 0, half], "translation_m": [1, 2, 3]}, "T")
    np.testing.assert_allclose(pose.apply([1.0, 0.0, 0.0]), [1.0, 3.0, 3.0], atol=1e-12)


@given(
    vector=st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    translation=st.lists(st.floats(-10, 10), min_size=3, max_size=3),
)
def test_poses_round_trip_as_json_and_matrix(vector: list[float], translation: list[float]) -> None:
    pose = RigidTransform.from_components(translation, Rotation.from_rotvec(vector))
    for back in (
        pose_from_json(pose_to_json(pose), "T"),
        pose_from_json(pose.as_matrix().tolist(), "T"),
        pose_from_matrix(pose.as_matrix(), "T"),
    ):
        np.testing.assert_allclose(back.as_matrix(), pose.as_matrix(), atol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), r"must be a \(4, 4\) number matrix, got \(3, 3\)"),
        (np.full((4, 4), "a"), "number matrix"),
        (_identity_except(0, 0, np.nan), "NaN or infinite"),
        (_identity_except(3, 0, 1.0), r"last row \[1.0, 0.0, 0.0, 1.0\], expected \[0, 0, 0, 1\]"),
        (_identity_except(0, 0, 1.1), "does not hold a rotation"),
        (_identity_except(2, 2, -1.0), "determinant -1, expected 1"),
        (_identity_except(2, 3, 549.0), "T_world_camera is 549 m from .* probably in mm"),
    ],
)
def test_invalid_matrices_are_rejected(matrix: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        pose_from_matrix(matrix, "T_world_camera")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([0, 0, 0], "must be .*quat_wxyz.*translation_m"),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], "rows of a .4, 4. matrix"),
        ([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]], "does not hold a rotation"),
        ([[1, 0, 0, 0], [0, 1, 0], [0, 0, 1, 0], [0, 0, 0, 1]], r"camera\[1\] must be a list of 4"),
        ({"quat_xyzw": [0, 0, 0, 1], "translation_m": [0, 0, 0]}, "must be .*quat_wxyz"),
        ({"quat_wxyz": [2, 0, 0, 0], "translation_m": [0, 0, 0]}, "length 2, expected 1"),
        ({"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, 549]}, "549 m from .* in mm"),
        ({"quat_wxyz": [1, 0, 0], "translation_m": [0, 0, 0]}, "list of 4 finite numbers"),
        ({"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, "a"]}, "list of 3 finite numbers"),
        ({"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, True]}, "list of 3 finite numbers"),
        ({"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, 10**400]}, "list of 3 finite"),
        ({"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, np.nan]}, "list of 3 finite"),
    ],
)
def test_invalid_json_is_rejected(value: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        pose_from_json(value, "T_world_camera")
