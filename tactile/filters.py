"""Moving averages of features: plain, and in the doubled angle for directions without a sense."""

from __future__ import annotations

import math
from collections import deque

from eyehand.errors import InputError

from .features import ContactFeatures
from .moments import half_angle

WINDOW = 10
"""Measurements averaged in the paper: 40 ms at 250 Hz."""


class MovingAverage:
    """Mean of the last so many values.

    Parameters
    ----------
    length
        How many, >= 1: longer is smoother and later, by half of it.
    """

    def __init__(self, length: int = WINDOW) -> None:
        self._values: deque[float] = deque(maxlen=_checked(length))

    def step(self, value: float) -> float:
        """Take a finite value in and give the mean."""
        if not math.isfinite(value):
            raise InputError(f"a value to be averaged must be finite, got {value}")
        self._values.append(value)
        return sum(self._values) / len(self._values)

    def reset(self) -> None:
        """Forget all values."""
        self._values.clear()


class MovingAngle:
    """Mean direction of the last so many angles that are equal modulo π.

    Each angle is a vector of length `confidence` at twice the angle; the mean's half angle is the
    direction. So ±90° average to 90° and not to 0, and angles of round contacts, which mean
    nothing, do not count.

    Parameters
    ----------
    length
        How many, >= 1: longer is smoother and later, by half of it.
    """

    def __init__(self, length: int = WINDOW) -> None:
        self._vectors: deque[tuple[float, float]] = deque(maxlen=_checked(length))
        self._last = 0.0

    def step(self, angle: float, confidence: float = 1.0) -> tuple[float, float]:
        """Take an angle (rad) and its confidence (0..1) in, and give those of the mean.

        The mean's angle is in (-π/2, π/2], and the one before where all confidences are 0 or
        cancel. Its confidence is the length of the mean vector: low also where angles disagree.
        """
        if not (math.isfinite(angle) and 0.0 <= confidence <= 1.0):
            raise InputError(
                f"an angle must be finite and its confidence in 0..1, got {angle}, {confidence}"
            )
        self._vectors.append(
            (confidence * math.cos(2.0 * angle), confidence * math.sin(2.0 * angle))
        )
        cosine = sum([vector[0] for vector in self._vectors])
        sine = sum([vector[1] for vector in self._vectors])
        length = math.hypot(cosine, sine) / len(self._vectors)
        if length > 1e-12:
            self._last = half_angle(cosine, sine)
        return self._last, min(length, 1.0)

    def reset(self) -> None:
        """Forget all angles."""
        self._vectors.clear()
        self._last = 0.0


class FeatureFilter:
    """Average force, pressure and orientation over the last features, as the paper does.

    The centre of pressure stays as it is: it is a mean over many tactels already. When contact is
    lost, all is forgotten, so a new contact starts from its own values.

    Parameters
    ----------
    length
        How many measurements, >= 1: the paper's 10 are 40 ms at 250 Hz; smoother and later.
    """

    def __init__(self, length: int = WINDOW) -> None:
        self._force = MovingAverage(length)
        self._pressure = MovingAverage(length)
        self._angle = MovingAngle(length)

    def step(self, features: ContactFeatures) -> ContactFeatures:
        """Take features in and give them averaged."""
        if not features:
            self.reset()
            return features
        angle, confidence = self._angle.step(features.orientation, features.confidence)
        return ContactFeatures(
            self._force.step(features.force),
            features.centre,
            self._pressure.step(features.pressure),
            features.area,
            angle,
            confidence,
            features.normal,
            features.tactels,
            features.border_share,
            features.saturated,
            features.interpolated,
        )

    def reset(self) -> None:
        """Forget all features."""
        self._force.reset()
        self._pressure.reset()
        self._angle.reset()


def _checked(length: int) -> int:
    if length < 1:
        raise InputError(f"a moving average needs a length >= 1, got {length}")
    return length
