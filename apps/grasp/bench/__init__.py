"""Benchmarks of grasping: success rates, charts, stress."""
