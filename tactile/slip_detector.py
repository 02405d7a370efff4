"""Raise an alarm when the score of a sequence of slip features exceeds a level."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import isnan

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

JUDGEMENT_LAGS = (0, 2, 6, 12)
"""Earlier judgements whose features a score also sees: 4, 13 and 25 ms ago at 475 judgements a
second."""


@dataclass(frozen=True)
class SlipScore:
    """A trained score of slip, and the level of an alarm.

    Raises
    ------
    InputError
        If the level is not a number.
    """

    score: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    """Function from features with their past, (M, K), to scores, (M,). See :func:`with_past`."""
    level: float
    """Score above which an alarm is raised."""

    def __post_init__(self) -> None:
        if isnan(self.level):
            raise InputError("the level of an alarm must be a number, got nan")


class SlipDetector:
    """A detector that judges the features of one pad, image by image.

    Parameters
    ----------
    trained
        Score and level.
    """

    def __init__(self, trained: SlipScore) -> None:
        self._trained = trained
        self._past: deque[NDArray[np.float64]] = deque(maxlen=JUDGEMENT_LAGS[-1] + 1)

    def update(self, features: NDArray[np.float64]) -> bool:
        """Enter the features of a judgement, (F,), and return whether they raise an alarm.

        Call it at the rate at which the score was trained.
        """
        self._past.append(features.copy())
        newest = len(self._past) - 1
        row = np.hstack([self._past[max(newest - lag, 0)] for lag in JUDGEMENT_LAGS])
        return bool(self._trained.score(row[None])[0] > self._trained.level)


def with_past(features: NDArray[np.floating]) -> NDArray[np.float64]:
    """Append the features of earlier judgements, (T, F) to (T, F len(JUDGEMENT_LAGS))."""
    rows = np.arange(len(features))
    return np.hstack([features[np.maximum(rows - lag, 0)] for lag in JUDGEMENT_LAGS]).astype(float)
