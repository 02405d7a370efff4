"""Benchmarks of the fit: accuracy, charts, comparisons, stress."""
