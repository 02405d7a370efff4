"""The velocity of obstacles from their poses, and the evasion of obstacles that approach."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import (
    ApproachController,
    CollisionWorld,
    ControlOptions,
    Obstacle,
    RobotModel,
    Sphere,
)
from eyehand.control.obstacle_motion import MAX_AGE, MAX_SPEED, ObstacleMotions
from eyehand.control.tasks import Position
from eyehand.data_synth import LBR_ARM

DT = 0.005


def _observed(velocity, turn, noise, seconds=0.3, every=1):
    motions, rng = ObstacleMotions(), np.random.default_rng(3)
    for cycle in range(round(seconds / DT)):
        motions.advance(DT)
        if cycle % every == 0:
            place = motions.clock * velocity + noise * rng.normal(size=3)
            rotation = Rotation.from_rotvec(motions.clock * turn)
            motions.observe("box", RigidTransform.from_components(place, rotation))
    return motions


@pytest.mark.parametrize("every", [1, 7])
def test_velocity_of_exact_poses_is_exact(every):
    velocity, turn = np.array([0.3, -0.4, 0.1]), np.array([0.0, 0.5, 1.0])
    motions = _observed(velocity, turn, 0.0, every=every)
    np.testing.assert_allclose(motions.twist("box"), [*velocity, *turn], atol=1e-9)
    assert motions.deviation("box") < 1e-9


def test_velocity_of_noisy_poses_has_its_deviation_and_a_still_obstacle_does_not_move():
    velocity = np.array([0.3, -0.4, 0.1])
    motions = _observed(velocity, np.zeros(3), 1e-3)
    deviation = motions.deviation("box")
    assert 1e-4 < deviation < 0.02
    np.testing.assert_allclose(motions.twist("box")[:3], velocity, atol=4 * deviation)
    still = _observed(np.zeros(3), np.zeros(3), 1e-3)
    assert np.linalg.norm(still.twist("box")[:3]) < 0.03


def test_obstacle_put_elsewhere_stands_still_and_so_does_one_without_news():
    motions = ObstacleMotions()
    motions.observe("box", RigidTransform.identity())
    motions.observe("box", RigidTransform.from_translation([1.0, 0.0, 0.0]))
    assert not np.any(motions.twist("box"))
    motions.advance(DT)
    far = RigidTransform.from_translation([1.0 + 1.1 * MAX_SPEED * DT, 0.0, 0.0])
    motions.observe("box", far)
    assert not np.any(motions.twist("box"))
    motions.advance(DT)
    motions.observe(
        "box", RigidTransform.from_translation(far.translation + np.array([2e-3, 0, 0]))
    )
    np.testing.assert_allclose(motions.twist("box"), [0.4, 0, 0, 0, 0, 0], atol=1e-9)
    ((name, shift),) = motions.advance(DT)
    assert name == "box"
    np.testing.assert_allclose(shift, [2e-3, 0.0, 0.0], atol=1e-9)
    for _ in range(round(MAX_AGE / DT) + 1):
        motions.advance(DT)
    assert not np.any(motions.twist("box"))


@pytest.mark.parametrize("velocity_given", [True, False])
@pytest.mark.parametrize("azimuth", [0.0, 1.2, -0.8])
def test_ball_at_half_a_metre_per_second_is_evaded(azimuth, velocity_given):
    robot = RobotModel.load(LBR_ARM, "tool")
    hand = robot.at(robot.home).position
    outward = np.array([np.cos(azimuth), np.sin(azimuth), 0.2])
    outward /= np.linalg.norm(outward)
    place = RigidTransform.from_translation
    world = CollisionWorld(robot, [Obstacle("ball", Sphere(0.05), place(hand + 0.5 * outward))])
    controller = ApproachController(world, [Position(hand)], ControlOptions(dt=DT))
    velocity, q, clearance = -0.5 * outward, robot.home.copy(), []
    for cycle in range(round(0.6 / 0.5 / DT)):
        pose = place(hand + 0.5 * outward + cycle * DT * velocity)
        world.move("ball", pose, [*velocity, 0, 0, 0] if velocity_given else None)
        step = controller.step(q)
        q = q + DT * step.velocity
        clearance.append(step.clearance)
        assert np.all(np.isfinite(q))
    assert min(clearance) > 0.005
