"""Candidates of several objects with their contacts, openings and terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .candidates import Candidates
from .scoring import ContactTable


@dataclass(frozen=True, eq=False)
class ScoredCandidates:
    """Candidates of all objects with their terms."""

    candidates: Candidates
    """Poses."""
    contact: ContactTable
    """Contacts."""
    opening: NDArray[np.float64]
    """Distance between the pads before closing, (n,), m."""
    terms: dict[str, NDArray[np.float64]]
    """Factors of the probability of success by name, (n,) each."""
    clearance: NDArray[np.float64]
    """Clearance from the own object and from others, (n, 2), m; zero before it is known."""
    hidden: NDArray[np.float64]
    """Share of each fingertip that other objects hide, (n, 2); zero before it is known."""
    deeper: NDArray[np.float64]
    """Distance by which the hand goes on along the approach unless it touches something, (n,), m;
    zero before it is known."""

    @property
    def total(self) -> NDArray[np.float64]:
        """Product of the terms, (n,)."""
        return np.prod(list(self.terms.values()), axis=0)

    def take(self, index: NDArray | slice) -> ScoredCandidates:
        """Return a part."""
        contact = self.contact
        return ScoredCandidates(
            self.candidates.take(index),
            ContactTable(
                contact.width[index],
                contact.cosine[index],
                contact.seen[index],
                contact.overlap[index],
                contact.middle[index],
            ),
            self.opening[index],
            {name: term[index] for name, term in self.terms.items()},
            self.clearance[index],
            self.hidden[index],
            self.deeper[index],
        )


def join_scored(parts: Sequence[ScoredCandidates]) -> ScoredCandidates:
    """Return the candidates of several tables, at least one, in one table."""
    tables = [part.contact for part in parts]
    return ScoredCandidates(
        Candidates.join([part.candidates for part in parts]),
        ContactTable(
            np.concatenate([t.width for t in tables]),
            np.concatenate([t.cosine for t in tables]),
            np.concatenate([t.seen for t in tables]),
            np.concatenate([t.overlap for t in tables]),
            np.concatenate([t.middle for t in tables]),
        ),
        np.concatenate([part.opening for part in parts]),
        {name: np.concatenate([part.terms[name] for part in parts]) for name in parts[0].terms},
        np.concatenate([part.clearance for part in parts]),
        np.concatenate([part.hidden for part in parts]),
        np.concatenate([part.deeper for part in parts]),
    )
