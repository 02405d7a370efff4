"""The second view of a doubtful object, and the fusion of two views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.grasp.bench.trial import GraspTrial, trial_cell
from eyehand.data_synth.scenes import TabletopObject
from eyehand.grasping import clearing
from eyehand.grasping.clearing import clear_table, observe
from eyehand.grasping.failed_grasps import FailedGrasps
from eyehand.grasping.grasp_selection import select_grasp
from eyehand.grasping.scene_fusion import fuse_scenes
from eyehand.grasping.second_view import VIEW_DISTANCE, view_again, view_directions
from eyehand.perception import Superquadric

HALF = np.array([0.03, 0.02, 0.035])


def box(name: str, x: float, y: float, half=HALF) -> TabletopObject:
    shape = Superquadric(half, (0.1, 0.1), RigidTransform.from_translation([x, y, half[2]]), "box")
    return TabletopObject(name, shape, 0.1, (0.8, 0.2, 0.2))


def total_variance(item) -> float:
    return sum(side.sigma**2 for side in item.fit.sides)


@pytest.fixture(scope="module")
def viewed():
    """Return cell and robot after a second view of a box, and the scenes before and after it."""
    cell, robot = trial_cell([box("box_1", 0.0, 0.0)], GraspTrial(wrist_camera=True))
    first, _, problem = observe(cell)
    assert first is not None, problem
    assert cell.wrist_camera is not None
    grasp = select_grasp(cell, first, FailedGrasps()).grasp
    assert grasp is not None
    return cell, robot, first, view_again(cell, cell.wrist_camera, grasp)


def test_second_view_reduces_uncertainty_of_sides(viewed):
    _, robot, first, second = viewed
    assert second.record.phase == "view"
    assert second.record.outcome == "done"
    assert 0.1 < second.record.end - second.record.start < 3.0
    assert second.compute_ms > 0.0
    assert robot.take_contacts() == set()
    (fused,) = second.scene.objects
    assert total_variance(fused) < 0.5 * total_variance(first.objects[0])
    solid = fused.fit.superquadric
    assert np.allclose(np.sort(solid.semi_axes), np.sort(HALF), atol=0.0015)
    assert np.allclose(solid.centre, [0.0, 0.0, HALF[2]], atol=0.002)


def test_wrist_camera_looks_at_object_from_its_distance(viewed):
    cell, _, first, second = viewed
    centre = first.objects[0].fit.superquadric.centre
    to_camera = second.scene.view_origin - centre
    assert np.linalg.norm(to_camera) == pytest.approx(VIEW_DISTANCE, abs=0.015)
    axis = (cell.palm_pose() * cell.wrist_camera.T_palm_camera).rotation.as_matrix()[:, 2]
    assert axis @ -to_camera / np.linalg.norm(to_camera) > 0.998


def test_best_view_shows_the_hidden_side_and_no_neighbour_hides_it(viewed):
    _, _, first, _ = viewed
    (item,) = first.objects
    best = view_directions(first, item)[0]
    worst_side = max(item.fit.sides, key=lambda side: side.sigma)
    assert best @ worst_side.direction > 0.2
    between = RigidTransform.from_translation(item.fit.superquadric.centre + 0.2 * best)
    ball = Superquadric(np.full(3, 0.09), (1.0, 1.0), between, "sphere")
    hidden = replace(item, label=2, fit=replace(item.fit, superquadric=ball, parts=(ball,)))
    behind = view_directions(replace(first, objects=(item, hidden)), item)[0]
    assert behind @ best < 0.95


def test_objects_of_one_view_are_kept_and_seen_ones_replaced(viewed):
    _, _, first, second = viewed
    (item,) = first.objects
    bare = replace(item.fit, superquadric=None, parts=())
    far = replace(item, label=2, points=item.points + np.array([0.3, 0.0, 0.0]), fit=bare)
    both = fuse_scenes(replace(first, objects=(item, far)), second.scene, 1)
    assert [one.label for one in both.objects] == [1, 2]
    assert np.array_equal(both.objects[1].points, far.points)
    # Where the views divide the objects otherwise, the second view counts for the viewed object.
    half = len(item.points) // 2
    pieces = tuple(
        replace(item, label=k + 1, points=part)
        for k, part in enumerate((item.points[:half], item.points[half:]))
    )
    divided = replace(first, objects=(*pieces, replace(far, label=3)))
    assert len(fuse_scenes(divided, second.scene, 1).objects) == 2
    assert len(fuse_scenes(divided, second.scene, 3).objects) == 3


def test_doubtful_grasp_is_viewed_again_and_time_is_charged(monkeypatch):
    monkeypatch.setattr(clearing, "is_doubtful", lambda plan: True)
    cell, _ = trial_cell([box("box_1", 0.0, 0.0)], GraspTrial(wrist_camera=True))
    (pick,) = clear_table(cell).picks
    assert pick.outcome == "placed"
    assert [one.phase for one in pick.phases][:2] == ["view", "pre-grasp"]
    assert pick.seconds > pick.phases[1].end - pick.phases[0].start
