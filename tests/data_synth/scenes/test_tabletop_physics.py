"""The physics of objects on a table: parking, placing, piling and measuring."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import Table, TabletopObject
from eyehand.data_synth.scenes.tabletop_physics import TabletopPhysics
from eyehand.perception.superquadric import Superquadric

RADIUS = 0.04


def balls(count: int) -> TabletopPhysics:
    shape = Superquadric(np.full(3, RADIUS), (1.0, 1.0), RigidTransform.identity(), "sphere")
    items = [TabletopObject(f"sphere_{k + 1}", shape, 0.1, (1.0, 0.0, 0.0)) for k in range(count)]
    return TabletopPhysics(items, Table())


def pose_at(x: float, y: float, z: float) -> RigidTransform:
    return RigidTransform.from_translation([x, y, z])


def test_parked_objects_do_not_move_or_prevent_rest():
    physics = balls(2)
    parked = physics.pose(1).translation
    physics.put(0, pose_at(0.0, 0.0, RADIUS))
    assert physics.settle(3.0)
    assert np.array_equal(physics.pose(1).translation, parked)
    assert np.allclose(physics.pose(0).translation, [0, 0, RADIUS], atol=1e-4)


def test_settle_counts_time_from_its_call():
    physics = balls(1)
    physics.put(0, pose_at(0.0, 0.0, RADIUS))
    physics.run(5.0)
    assert physics.settle(0.5)


def test_no_creep_stops_sliding_on_slope():
    """Far from its centre, the bowl force is almost constant. Here it equals a slope of 6°."""
    shape = Superquadric(np.array([0.02, 0.02, 0.01]), (0.3, 0.3), RigidTransform.identity())
    item = TabletopObject("superquadric_1", shape, 0.1, (1.0, 0.0, 0.0))
    sliding = []
    for no_creep in (False, True):
        physics = TabletopPhysics([item], Table(), no_creep=no_creep)
        physics.put(0, pose_at(0.3, 0.0, 0.01))
        physics.bowl(0.1, 1.0)
        physics.run(0.3)
        before = physics.pose(0).translation
        physics.run(1.0)
        sliding.append(float(np.linalg.norm(physics.pose(0).translation - before)))
    assert sliding[0] > 1e-5
    assert sliding[1] < 1e-7


def test_bowl_force_moves_ball_to_centre():
    physics = balls(1)
    physics.put(0, pose_at(0.2, 0.1, RADIUS))
    physics.settle(3.0)
    assert np.allclose(physics.pose(0).translation[:2], [0.2, 0.1], atol=1e-3)
    physics.bowl(0.1, 4.0)
    physics.settle(4.0)
    assert np.linalg.norm(physics.pose(0).translation[:2]) < 0.03
    assert physics.pose(0).translation[2] == pytest.approx(RADIUS, abs=1e-4)
    physics.bowl(0.1, 0.0)
    assert physics.settle(3.0)


@pytest.mark.parametrize(
    ("one", "other", "depth"),
    [
        (pose_at(0, 0, RADIUS), pose_at(0.1, 0, RADIUS), 0.0),
        (pose_at(0, 0, RADIUS), pose_at(0.07, 0, RADIUS), 0.01),
        (pose_at(0, 0, RADIUS - 0.005), pose_at(0.1, 0, RADIUS), 0.005),
    ],
)
def test_max_penetration_includes_objects_and_table(
    one: RigidTransform, other: RigidTransform, depth: float
):
    physics = balls(2)
    physics.put(0, one)
    physics.put(1, other)
    assert physics.max_penetration() == pytest.approx(depth, abs=1e-5)


def test_unstable_simulation_is_never_at_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warning log to the working directory.
    physics = balls(2)
    physics.put(0, pose_at(0.0, 0.0, RADIUS))
    physics.put(1, pose_at(0.3, 0.0, np.nan))
    assert not physics.unstable
    assert not physics.settle(1.0)
    assert physics.unstable
