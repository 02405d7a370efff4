"""The simulated grasping cell: arm, hands, drives, fingertip pads and the robot."""
