"""Segmentation measured: scores, charts, comparisons, stress."""
