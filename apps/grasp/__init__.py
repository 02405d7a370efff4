"""Unknown objects grasped by the simulated robot: trials, their dials, the demo."""
