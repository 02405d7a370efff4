"""Checks of the arrays that callers pass in."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError


def checked_array(
    name: str, value: object, shape: tuple[int | str, ...], *, finite: bool = True
) -> NDArray[np.float64]:
    """Return a copy of an array of numbers.

    Parameters
    ----------
    name
        Name of the array for the error message.
    value
        The numbers.
    shape
        The shape. A letter stands for a dimension of any length.
    finite
        Whether infinity and NaN are rejected.

    Raises
    ------
    InputError
        If the value is not numbers, has another shape, or is not finite.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be numbers, got {value!r}") from error
    if array.ndim != len(shape) or any(
        isinstance(size, int) and size != got for size, got in zip(shape, array.shape, strict=True)
    ):
        wanted = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
        raise InputError(f"{name} must have shape {wanted}, got {array.shape}: {value!r}")
    if finite and not np.isfinite(array).all():
        raise InputError(f"{name} must be finite, got {array.tolist()}")
    return array


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only and return it."""
    array.flags.writeable = False
    return array
