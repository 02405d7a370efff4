"""Options of the commands that repeat one trial with different seeds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cyclopts import Parameter


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TrialArguments:
    """The options that the experiments with repeated trials share."""

    trials: int | None = None
    """Number of trials, >= 1; default: 20 (edge 10, cable 5), and fewer with --quick."""
    seed: int = 0
    """Trial k draws its pad, its noise and its start from seed + k."""
    quick: bool = False
    """Run few or short trials, for a first look."""
    out: Path | None = None
    """Output folder; default: out/experiment_NAME."""
    json: bool = False
    """Print one JSON object on stdout. The table then goes to stderr."""
