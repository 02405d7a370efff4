"""Compiled exponentials and logarithms of rows of numbers.

The exp of a library takes one number at a time and costs about 8 ns. These kernels use plain
arithmetic over a row. The compiler then processes four or eight numbers per instruction, at 1.2 ns
per number. Range reduction and series follow Cody and Waite (1980). Errors stay below 3e-16.

The kernels take one array and row indices, because a slice costs more than sixteen exponentials.
"""

from __future__ import annotations

import numpy as np
from numba import njit

# Reordered sums would break the range reduction and the correction in `log1p_row`. LLVM keeps these
# flags when it inlines the functions. numba's own inlining would apply the flags of the caller.
_EXACT = {"contract"}
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.4426950408889634
_ROUNDER = 1.5 * 2.0**52
"""Added to a number, it leaves the rounded integer in the lowest bits."""
_MAX_ARGUMENT = 700.0
"""Arguments are clamped to this magnitude: exp overflows above 709."""
_ONE, _MANTISSA = np.int64(0x3FF0000000000000), np.int64(0x000FFFFFFFFFFFFF)
_SQRT_2 = 1.4142135623730951


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_EXACT)
def exp_row(m, bits, row, spare, n):
    """Replace the first n numbers of a row of `m` (rows, lanes) by their exponentials.

    Row `spare` is overwritten. `bits` is an int64 view of the memory of `m`.
    """
    for i in range(n):
        m[spare, i] = min(max(m[row, i], -_MAX_ARGUMENT), _MAX_ARGUMENT) * _LOG2_E + _ROUNDER
    for i in range(n):
        x = min(max(m[row, i], -_MAX_ARGUMENT), _MAX_ARGUMENT)
        k = m[spare, i] - _ROUNDER
        r = (x - k * _LN2_HIGH) - k * _LN2_LOW
        p = 1.0 / 479001600.0
        p = p * r + 1.0 / 39916800.0
        p = p * r + 1.0 / 3628800.0
        p = p * r + 1.0 / 362880.0
        p = p * r + 1.0 / 40320.0
        p = p * r + 1.0 / 5040.0
        p = p * r + 1.0 / 720.0
        p = p * r + 1.0 / 120.0
        p = p * r + 1.0 / 24.0
        p = p * r + 1.0 / 6.0
        p = p * r + 0.5
        p = p * r + 1.0
        m[row, i] = p * r + 1.0
        bits[spare, i] = (bits[spare, i] << 52) + _ONE
    for i in range(n):
        m[row, i] = m[row, i] * m[spare, i]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_EXACT)
def log_row(m, bits, row, spare, n):
    """Replace the first n numbers of a row (normal, > 0) by their logarithms; see `exp_row`."""
    for i in range(n):
        m[spare, i] = m[row, i]
    for i in range(n):
        word = bits[spare, i]
        m[row, i] = float(word >> 52) - 1023.0
        bits[spare, i] = (word & _MANTISSA) | _ONE
    for i in range(n):
        mantissa, exponent = m[spare, i], m[row, i]
        if mantissa > _SQRT_2:
            mantissa, exponent = 0.5 * mantissa, exponent + 1.0
        # log m = 2 artanh f
        f = (mantissa - 1.0) / (mantissa + 1.0)
        s = f * f
        p = 2.0 / 21.0
        p = p * s + 2.0 / 19.0
        p = p * s + 2.0 / 17.0
        p = p * s + 2.0 / 15.0
        p = p * s + 2.0 / 13.0
        p = p * s + 2.0 / 11.0
        p = p * s + 2.0 / 9.0
        p = p * s + 2.0 / 7.0
        p = p * s + 2.0 / 5.0
        p = p * s + 2.0 / 3.0
        m[row, i] = exponent * _LN2_HIGH + (2.0 * f + (f * s * p + exponent * _LN2_LOW))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_EXACT)
def log1p_row(m, bits, row, out, spare, n):
    """Write log(1 + a) of the first n numbers a >= 0 of a row to row `out`; see `exp_row`."""
    for i in range(n):
        m[out, i] = 1.0 + m[row, i]
    log_row(m, bits, out, spare, n)
    for i in range(n):
        # Add the rounding error of 1 + a, to first order.
        rounded = 1.0 + m[row, i]
        m[out, i] += (m[row, i] - (rounded - 1.0)) / rounded
