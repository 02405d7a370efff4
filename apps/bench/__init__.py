"""The measuring harness: sweeps, charts, comparisons of methods, reports."""
