"""How sure a share is that was counted on few cases: the Wilson score interval."""

from __future__ import annotations

from math import sqrt
from statistics import NormalDist

from eyehand.errors import InputError

CONFIDENCE = 0.95
"""Share of intervals that hold the true value."""


def wilson_interval(wins: int, tries: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Give the interval that holds a true share (Wilson 1927, without continuity correction).

    Its ends are the shares p with (wins/tries - p)² = z² p (1 - p) / tries. Unlike the plain normal
    interval it stays within 0 and 1, and is not a point where all or none succeeded.

    Parameters
    ----------
    wins, tries
        So many of so many, 0 <= wins <= tries.
    confidence
        Of the interval, between 0 and 1.

    Returns
    -------
    low, high
        From 0 to 1; (0, 1) without tries: nothing is known.

    Raises
    ------
    InputError
        If a value is out of its range.
    """
    if not 0 <= wins <= tries:
        raise InputError(f"wins must be from 0 to the {tries} tries, got {wins}")
    if not 0 < confidence < 1:
        raise InputError(f"confidence must lie between 0 and 1, got {confidence}")
    if tries == 0:
        return 0.0, 1.0
    z2 = NormalDist().inv_cdf((1 + confidence) / 2) ** 2
    share = wins / tries
    middle = (share + z2 / (2 * tries)) / (1 + z2 / tries)
    half = sqrt(z2 * (share * (1 - share) / tries + z2 / (4 * tries**2))) / (1 + z2 / tries)
    # Where all or none succeeded, one end is exact; rounding must not lose it.
    low = 0.0 if wins == 0 else middle - half
    high = 1.0 if wins == tries else middle + half
    return low, high
