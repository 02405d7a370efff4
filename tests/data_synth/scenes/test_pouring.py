"""Objects lowered into furniture: those beside it are removed, those in it stay where they fell."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import TabletopObject
from eyehand.data_synth.scenes import furniture
from eyehand.data_synth.scenes.furnished_scene import object_pose
from eyehand.data_synth.scenes.furnished_settings import DropZone
from eyehand.data_synth.scenes.pouring import FurnishedPhysics, pour
from eyehand.perception.superquadric import Superquadric

GREY = (0.5, 0.5, 0.5)


def cubes(count: int) -> list[TabletopObject]:
    shape = Superquadric(np.full(3, 0.02), (0.1, 0.1), RigidTransform.identity(), "box")
    return [TabletopObject(f"box_{k}", shape, 0.02, GREY) for k in range(count)]


def poured(zone: DropZone, count: int) -> list[np.ndarray]:
    parts = [*furniture.table((0.3, 0.3), 0.5, GREY), furniture.ground(-0.5, GREY)]
    objects = cubes(count)
    physics = FurnishedPhysics(objects, parts)
    found = pour(objects, [zone], physics, np.random.default_rng(0))
    assert not isinstance(found, str), found
    return [object_pose(item).translation for item in found]


def test_objects_on_the_table_stay_and_do_not_overlap():
    places = poured(DropZone(RigidTransform.identity(), (0.08, 0.08), upright=1.0), 3)
    assert len(places) == 3
    assert all(0.0195 < place[2] < 0.15 for place in places)
    for k, place in enumerate(places):
        others = np.array(places[:k]).reshape(-1, 3)
        assert np.all(np.abs(place - others).max(axis=1) > 0.0395)


def test_objects_beside_the_table_are_removed():
    beside = RigidTransform.from_translation([0.2, 0.0, 0.0])
    assert poured(DropZone(beside, (0.01, 0.01)), 2) == []


def test_zone_holds_points_over_its_rectangle_and_below_its_headroom():
    zone = DropZone(RigidTransform.from_translation([1.0, 0.0, 0.5]), (0.1, 0.2), headroom=0.3)
    points = np.array([[1, 0, 0.6], [1.15, 0, 0.6], [1, 0, 0.4], [1, 0, 0.9], [1, 0.25, 0.6]])
    assert zone.holds(points, 0.0).tolist() == [True, False, False, False, False]
    assert zone.holds(points, 0.06).tolist() == [True, True, False, False, True]
