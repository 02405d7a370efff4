"""Simulated scenes: objects on a table, staged solids, reaching scenes, and data set files."""
