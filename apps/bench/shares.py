"""Rates of trials in %, their confidence intervals, and how stress charts draw them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError

from .chart_style import INK

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from matplotlib.axes import Axes

    from .sweep import SweepStep, Trial

BAR_STYLE: dict[str, Any] = {"width": 0.82, "linewidth": 0, "zorder": 1.2}
"""Style of all bars: behind the curves, nearly as wide as the distance between two neighbouring
values."""
DOTTED = (0, (1, 1.4))
"""Line style of a second curve."""
CONFIDENCE = 0.95
"""Share of intervals that contain the true value."""


def wilson_interval(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % interval of a proportion (Wilson 1927, no continuity correction).

    Unlike the normal interval it stays within 0 and 1, and it is not a point when all or none
    succeeded.

    Parameters
    ----------
    successes, trials
        Number of successes and of trials, 0 <= successes <= trials.

    Returns
    -------
    low, high
        From 0 to 1; (0, 1) without trials.

    Raises
    ------
    InputError
        If a value is out of its range.
    """
    if not 0 <= successes <= trials:
        raise InputError(f"successes must be from 0 to the {trials} trials, got {successes}")
    if trials == 0:
        return 0.0, 1.0
    from scipy.stats import binomtest

    interval = binomtest(successes, trials).proportion_ci(CONFIDENCE, method="wilson")
    return float(interval.low), float(interval.high)


def share_pct(step: SweepStep, condition: Callable[[Trial], bool]) -> float:
    """Return the percentage of a step's trials that meet a condition."""
    return 100 * sum(map(condition, step.trials)) / len(step.trials)


def refused_pct(step: SweepStep) -> float:
    """Return the percentage of trials that the method refused with a reason."""
    return share_pct(step, lambda trial: trial.refused)


def unclean_pct(step: SweepStep) -> float:
    """Return the percentage of trials with an invalid answer or a violated safety rule."""
    return share_pct(step, lambda trial: not trial.clean)


def score_pct(step: SweepStep) -> float | None:
    """Return the mean score in % of the trials that have one."""
    return 100 * sum(step.scores) / len(step.scores) if step.scores else None


def percent(share: float | None, digits: int = 1) -> float | None:
    """Convert a share to rounded per cent; None stays None."""
    return None if share is None else round(100 * share, digits)


def milliseconds(step: SweepStep) -> float | None:
    """Return the median time of a step, ms, rounded; None when none was measured."""
    seconds = step.median_seconds
    return None if seconds is None else round(1e3 * seconds, 1)


def worst(
    values: Iterable[float | None],
    digits: int,
    pick: Callable[[list[float]], float] = max,
) -> float | None:
    """Return the worst measured value to `digits` significant digits; None without values.

    `pick` selects it: `max` if high values are bad, `min` if low ones are.
    """
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
    """Draw shares in % as bars behind the curves; `on` is the height of the bars below."""
    axes.bar(places, shares, bottom=on, color=colour, alpha=alpha, label=label, **BAR_STYLE)


def draw_dotted(
    axes: Axes, places: Sequence[float], shares: Sequence[float | None], label: str
) -> None:
    """Draw shares in % as a second, dotted curve; None is left out."""
    known = [(x, share) for x, share in zip(places, shares, strict=True) if share is not None]
    axes.plot(
        [x for x, _ in known],
        [share for _, share in known],
        color=INK,
        linewidth=1.1,
        linestyle=DOTTED,
        label=label,
        clip_on=False,
        zorder=3.2,
    )
