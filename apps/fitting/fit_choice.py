"""Convert the choices on the command line to fit options."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from eyehand.errors import InputError
from eyehand.perception import FitOptions
from eyehand.perception.superquadric import MAX_PARTS, Kind, OptimiserName

KindChoice = Literal["auto"] | Kind
"""A kind of solid; ``auto`` selects the simplest kind that explains the points."""
MAX_NOISE_MM = 100.0
"""Maximum noise, mm."""


@dataclass(frozen=True)
class FitChoice:
    """The fit choices of the command line; None selects the default.

    Raises
    ------
    InputError
        If a value is out of range. The message names the option and the range.
    """

    kind: KindChoice = "auto"
    """Solid to fit."""
    noise_mm: float = 1.5
    """Expected noise of the points, one standard deviation, mm."""
    budget_ms: float | None = None
    """Time limit of a fit, ms."""
    max_parts: int | None = None
    """Maximum number of solids per object."""
    points: int | None = None
    """Number of points used."""
    optimiser: OptimiserName | None = None
    """Optimiser of the final refinement."""

    def __post_init__(self) -> None:
        if not 0.0 < self.noise_mm <= MAX_NOISE_MM:
            raise InputError(
                f"--noise-mm must be above 0 and at most {MAX_NOISE_MM:g}, got {self.noise_mm}"
            )
        if self.max_parts is not None and not 1 <= self.max_parts <= MAX_PARTS:
            raise InputError(f"--max-parts must be 1 to {MAX_PARTS}, got {self.max_parts}")
        if self.budget_ms is not None and not 0.0 < self.budget_ms < float("inf"):
            raise InputError(f"--budget-ms must be finite and above 0, got {self.budget_ms}")
        for name in ("points", "optimiser"):
            if self.budget_ms is not None and getattr(self, name) is not None:
                raise InputError(
                    f"--budget-ms and --{name} exclude each other: --budget-ms selects the {name}"
                )

    def options(self) -> FitOptions:
        """Return the options of the fit.

        Raises
        ------
        InputError
            If no setting of the stored front meets the budget, or a value is out of range.
        """
        chosen = FitOptions() if self.budget_ms is None else FitOptions.for_budget(self.budget_ms)
        changes: dict[str, Any] = {"noise": self.noise_mm * 1e-3}
        if self.kind != "auto":
            changes["kinds"] = (self.kind,)
        for name in ("points", "optimiser", "max_parts"):
            if getattr(self, name) is not None:
                changes[name] = getattr(self, name)
        return replace(chosen, **changes)
