"""Counts and seed ranges in words."""

from __future__ import annotations


def counted(count: int, noun: str) -> str:
    """Return a count with its noun: ``1 scene``, ``2 scenes``."""
    return f"{count} {plural(count, noun)}"


def plural(count: int, noun: str) -> str:
    """Return a noun in singular or plural. The plural must end in a plain s."""
    return noun if count == 1 else f"{noun}s"


def seed_span(first: int, count: int) -> str:
    """Return the words for consecutive seeds: ``seed 3``, ``seeds 3 to 7``."""
    return f"seed {first}" if count == 1 else f"seeds {first} to {first + count - 1}"
