"""Settings of a run of the clutter-removal protocol."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from pathlib import Path

    from eyehand.data_synth.scenes import Split

QUICK_ROUNDS = 1
"""Maximum number of rounds of a quick run."""


@dataclass(frozen=True)
class ProtocolSettings:
    """What a run of the protocol is asked to measure."""

    families: tuple[str, ...]
    """packed, pile."""
    noises: tuple[Literal["none", "dex"], ...]
    """none, dex."""
    rounds: int
    """Rounds of each row."""
    seed: int
    """Seed of the first round."""
    objects: Path
    """Folder with the subfolders packed and pile, or with the objects of one family."""
    hand: str = "panda"
    """Name or file of the hand."""
    known_table: bool = False
    """Whether the depth is corrected from the known height of the table."""
    split: Split = "all"
    """Which half of the objects is used."""
    jobs: int | None = None
    """Number of processes; None for the number of cores."""
    depth_error: float | None = None
    """Depth error that the planner expects; None for its default."""
