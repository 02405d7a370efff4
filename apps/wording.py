"""Counted things in words."""

from __future__ import annotations


def counted(count: int, noun: str) -> str:
    """Put a count before a noun: ``1 scene``, ``2 scenes``."""
    return f"{count} {plural(count, noun)}"


def plural(count: int, noun: str) -> str:
    """Give a noun as it stands after a count; only nouns whose plural ends in a bare s."""
    return noun if count == 1 else f"{noun}s"


def seed_span(first: int, count: int) -> str:
    """Name consecutive seeds: ``seed 3``, ``seeds 3 to 7``."""
    return f"seed {first}" if count == 1 else f"seeds {first} to {first + count - 1}"
