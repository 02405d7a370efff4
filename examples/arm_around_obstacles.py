"""Move an arm around a block to a position, with limits of speed, acceleration and distance."""

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.control import ApproachController, Box, CollisionWorld, Obstacle, RobotModel
from eyehand.control.tasks import Position
from eyehand.data_synth import LBR_ARM


def main():
    robot = RobotModel.load(LBR_ARM, "tool")  # an MJCF or URDF of your arm, and its tool frame
    place = RigidTransform.from_translation([0.4, 0.3, 0.2])
    world = CollisionWorld(robot, [Obstacle("block", Box(np.array([0.1, 0.1, 0.2])), place)])
    controller = ApproachController(world, [Position(np.array([0.3, 0.5, 0.4]))])
    q, seconds = robot.home, 0.0
    while (cycle := controller.step(q)).status == "moving":
        q = q + controller.options.dt * cycle.velocity  # your robot takes cycle.velocity here
        seconds += controller.options.dt
    print(f"{cycle.status} after {seconds:.2f} s {cycle.reason}")


if __name__ == "__main__":
    main()
