"""Shares of the trials of a step, in %, and how every stress chart draws them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .chart_style import INK

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from matplotlib.axes import Axes

    from .sweep import Step, Trial

BAR: dict[str, Any] = {"width": 0.82, "linewidth": 0, "zorder": 1.2}
"""Look of all bars: behind the curves, nearly as wide as a value's place."""
DOTS = (0, (1, 1.4))
"""Dashes of a second curve: it must not be taken for the first."""


def share_pct(step: Step, holds: Callable[[Trial], bool]) -> float:
    """Give the share of a step's trials for which something holds, %."""
    return 100 * sum(map(holds, step.trials)) / len(step.trials)


def refused_pct(step: Step) -> float:
    """Give the share of trials that ended in a refusal with its reason, %."""
    return share_pct(step, lambda trial: trial.refused)


def unclean_pct(step: Step) -> float:
    """Give the share of trials that did what none may, %."""
    return share_pct(step, lambda trial: not trial.clean)


def score_pct(step: Step) -> float | None:
    """Give the mean score of the trials that have one, %."""
    return 100 * sum(step.scores) / len(step.scores) if step.scores else None


def worst(
    values: Iterable[float | None],
    digits: int,
    pick: Callable[[list[float]], float] = max,
) -> float | None:
    """Give the worst of the values measured, to some significant digits; None of none."""
    known = [value for value in values if value is not None]
    return float(f"{pick(known):.{digits}g}") if known else None


def draw_bars(
    axes: Axes,
    places: Sequence[float],
    shares: Sequence[float],
    label: str,
    colour: str,
    alpha: float,
    on: Sequence[float] | float = 0.0,
) -> None:
    """Draw shares, %, as bars behind the curves, on other bars where told."""
    axes.bar(places, shares, bottom=on, color=colour, alpha=alpha, label=label, **BAR)


def draw_dotted(
    axes: Axes, places: Sequence[float], shares: Sequence[float | None], label: str
) -> None:
    """Draw shares, %, as a second, dotted curve; values without one are passed over."""
    known = [(x, share) for x, share in zip(places, shares, strict=True) if share is not None]
    axes.plot(
        [x for x, _ in known],
        [share for _, share in known],
        color=INK,
        linewidth=1.1,
        linestyle=DOTS,
        label=label,
        clip_on=False,
        zorder=3.2,
    )
