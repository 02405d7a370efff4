"""Fitted clouds for several tests of this folder."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.fit_inputs import Cloud, FittedCloud
from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import Rim, Vessel, sample_surface

POSE = RigidTransform.from_components(
    [0.1, -0.2, 0.3], Rotation.from_euler("xyz", [20.0, -35.0, 50.0], degrees=True)
)


@pytest.fixture(scope="session")
def can() -> FittedCloud:
    """Return a can of 80 x 80 x 120 mm at a general pose, measured from all sides, 0.5 mm noise."""
    solid = Superquadric(np.array([0.04, 0.04, 0.06]), (0.1, 1.0), POSE, "cylinder")
    rng = np.random.default_rng(1)
    points = sample_surface(solid, 900, rng) + rng.normal(scale=5e-4, size=(900, 3))
    fit = fit_superquadric(points, options=FitOptions())
    return FittedCloud(Cloud("can.ply", "can", points), fit)


@pytest.fixture(scope="session")
def lens() -> FittedCloud:
    """Return a rounded block, fitted as a superquadric, with known camera and support plane."""
    solid = Superquadric(np.array([0.05, 0.03, 0.02]), (0.5, 0.6), RigidTransform.identity())
    points = sample_surface(solid, 900, np.random.default_rng(2))
    fit = fit_superquadric(points, options=FitOptions(kinds=("superquadric",)))
    cloud = Cloud(
        "lens.xyz", "lens", points, np.array([0.0, -0.6, 0.5]), np.array([0.0, 0.0, 1.0, 0.02])
    )
    return FittedCloud(cloud, fit)


@pytest.fixture(scope="session")
def unfit() -> FittedCloud:
    """Return a cloud without a solid."""
    points = np.random.default_rng(3).normal(size=(200, 3))
    return FittedCloud(Cloud("mist.xyz", "mist", points), SuperquadricFit.rejected("it is mist"))


@pytest.fixture(scope="session")
def hammer() -> FittedCloud:
    """Return a block on a stick, fitted as two solids."""
    lying = Rotation.from_euler("y", 90.0, degrees=True)
    stick = Superquadric(
        np.array([0.012, 0.012, 0.1]),
        (0.1, 1.0),
        RigidTransform.from_components([0.0, 0.0, 0.012], lying),
        "cylinder",
    )
    block = Superquadric(
        np.array([0.02, 0.045, 0.018]),
        (0.1, 0.1),
        RigidTransform.from_translation([0.11, 0.0, 0.018]),
        "box",
    )
    rng = np.random.default_rng(4)
    points = np.concatenate([sample_surface(part, 500, rng) for part in (block, stick)])
    off = np.min(np.abs([part.distance(points) for part in (block, stick)]), axis=0)
    fit = SuperquadricFit(block, True, "", off, (), 0.02, parts=(block, stick))
    cloud = Cloud("hammer.ply", "hammer", points, np.array([0.3, -0.5, 0.6]))
    return FittedCloud(cloud, fit)


@pytest.fixture(scope="session")
def mug() -> FittedCloud:
    """Return a mug of 80 x 80 x 90 mm with a wall of 4 mm and a handle, seen from above."""
    body = Superquadric(
        np.array([0.04, 0.04, 0.045]),
        (0.05, 1.0),
        RigidTransform.from_translation([0.0, 0.0, 0.045]),
        "cylinder",
    )
    handle = Superquadric(
        np.array([0.015, 0.005, 0.03]),
        (0.5, 0.5),
        RigidTransform.from_translation([0.054, 0.0, 0.045]),
    )
    rim = Rim(np.array([0.0, 0.0, 0.09]), np.array([0.038, 0.038]), np.eye(3)[:2])
    rng = np.random.default_rng(5)
    points = np.concatenate([sample_surface(part, 500, rng) for part in (body, handle)])
    vessel = Vessel(body, rim, 0.004)
    fit = SuperquadricFit(
        body, True, "", np.zeros(1000), (), 0.02, parts=(body, handle), vessel=vessel
    )
    cloud = Cloud("mug.ply", "mug", points, np.array([0.1, -0.5, 0.6]), np.array([0, 0, 1.0, 0]))
    return FittedCloud(cloud, fit)
