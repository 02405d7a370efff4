"""The simulated grasp demo: its scenes, its record, its report and its film."""
