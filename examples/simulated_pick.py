"""Pick an unknown object in simulation and put it into a tray."""

import logging

import numpy as np

from eyehand.apps.grasp.scenes import grasp_scene
from eyehand.data_synth.cell import GraspWorld, SimRobot
from eyehand.grasping import Cell, Tray, clear_table
from eyehand.perception import perceive


def main(seed=8):
    robot = SimRobot(GraspWorld.build(grasp_scene("single", seed).objects))
    tray = Tray(centre=np.array([0.43, -0.19, 0.006]), size=(0.25, 0.36), wall_height=0.07)
    logging.basicConfig(level=logging.INFO)  # a line for each image and pick
    report = clear_table(Cell(robot, perceive, tray))
    for pick in report.picks:
        print(pick)
    print("ended:", report.stop_reason)


if __name__ == "__main__":
    main()
