"""Sweeps of stability: the same frame with more and more readings moved by 1 mm."""

from __future__ import annotations

from collections.abc import Callable

from ..bench import Sweep, Trial
from .self_agreement import disturbed_frame, self_agreement
from .stress_trial import SegmentCallable, TrialPicture, timed_segment
from .synthetic_frames import EMPTY_FAMILIES, FAMILIES, synthetic_sources

SHARES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Shares of the readings that move, %."""
HOLDS_TO = 0.5
"""Share up to which the segmentation must agree with itself, %."""
MIN_AGREEMENT = 0.95
"""Minimum share of the labelled pixels that keep their object."""


def _agreement_sweep(family: str) -> Sweep[SegmentCallable]:
    return Sweep(
        name=f"agree-{family}",
        axis=f"readings moved by ±1 mm, {family} scenes",
        unit="%",
        values=SHARES,
        holds_to=HOLDS_TO,
        attempt=_attempt(family),
        right=f"{100 * MIN_AGREEMENT:g} % of the labelled pixels keep their object",
    )


def _attempt(family: str) -> Callable[[float, int, SegmentCallable], Trial]:
    def attempt(share: float, seed: int, method: SegmentCallable) -> Trial:
        (source,) = synthetic_sources([family], ["realistic"], frames=1, seed=seed)
        labelled = source.load()
        moved = disturbed_frame(labelled.frame, share / 100, seed)
        before = method(labelled.frame).labels
        found, seconds, fault = timed_segment(method, moved)
        picture = TrialPicture(moved, found.labels, before)
        if fault:
            return Trial(False, fault, clean=False, seconds=seconds, picture=picture)
        agreement = self_agreement(before, found.labels)
        stable = agreement >= MIN_AGREEMENT
        note = "" if stable else f"{100 * agreement:.0f} % keep their object"
        return Trial(stable, note, score=agreement, seconds=seconds, picture=picture)

    return attempt


AGREEMENT_SWEEPS = tuple(
    _agreement_sweep(family) for family in FAMILIES if family not in EMPTY_FAMILIES
)
"""One sweep per family of synthetic scenes."""
