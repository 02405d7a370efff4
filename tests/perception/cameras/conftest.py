"""Fixtures: small random depth frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.frame import CameraIntrinsics, DepthFrame

if TYPE_CHECKING:
    from collections.abc import Callable

WIDTH, HEIGHT = 64, 48


@pytest.fixture
def camera() -> CameraIntrinsics:
    return CameraIntrinsics(51.3, 50.7, 31.9, 23.6, WIDTH, HEIGHT)


@pytest.fixture
def pose() -> RigidTransform:
    rotation = Rotation.from_euler("xyz", [0.1, 2.8, -0.4])
    return RigidTransform.from_components([0.12, -0.34, 0.95], rotation)


@pytest.fixture
def millimetres() -> Callable[[int], np.ndarray]:
    """Return a function that draws RAW16 pixels over the full 16-bit range, ends included."""

    def pixels(number: int) -> np.ndarray:
        values = np.random.default_rng(number).integers(0, 65536, (HEIGHT, WIDTH))
        values[0, :3] = (0, 1, 65535)
        return values.astype(np.uint16)

    return pixels


@pytest.fixture
def frames(
    camera: CameraIntrinsics, millimetres: Callable[[int], np.ndarray]
) -> Callable[..., list[DepthFrame]]:
    """Return a function that makes `count` different frames, with or without colour."""

    def make(count: int, *, colour: bool = False) -> list[DepthFrame]:
        result = []
        for number in range(count):
            depth = millimetres(number).astype(np.float32) / np.float32(1000)
            rgb = np.random.default_rng(1000 + number).integers(0, 256, (HEIGHT, WIDTH, 3))
            result.append(
                DepthFrame(depth, camera, colour=rgb.astype(np.uint8) if colour else None)
            )
        return result

    return make
