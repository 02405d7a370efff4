"""Plan grasps of parallel jaws."""
