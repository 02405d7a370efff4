"""Compiled exponentials and logarithms of short rows of numbers, several to an instruction.

A library's `exp` takes one number at a time and costs some 8 ns; written as plain arithmetic over a
row, the compiler puts four or eight numbers into each instruction: 1.4 ns. Range reduction and
series are the textbook's (Cody and Waite 1980); errors stay below 3e-16.
"""

from __future__ import annotations

import numpy as np
from numba import njit

# Liberties with sums would undo what the range reduction and `log1p_all` take care of. These hold
# as long as LLVM inlines the functions; numba's own inlining would apply the caller's.
_EXACT = {"contract"}
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.4426950408889634
_ROUNDER = 1.5 * 2.0**52
"""Added to a number, leaves it rounded in the lowest bits."""
_MOST = 700.0
"""Arguments beyond are held there: exp(709) is the last finite one."""
_ONE, _MANTISSA = np.int64(0x3FF0000000000000), np.int64(0x000FFFFFFFFFFFFF)
_SQRT_2 = 1.4142135623730951


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_EXACT)
def exp_all(argument, out, spare):
    """Write exp of `argument` (N,) to `out` (N,), which may be the same; `spare` is overwritten."""
    bits = spare.view(np.int64)
    for i in range(argument.size):
        spare[i] = min(max(argument[i], -_MOST), _MOST) * _LOG2_E + _ROUNDER
    for i in range(argument.size):
        x = min(max(argument[i], -_MOST), _MOST)
        k = spare[i] - _ROUNDER
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
        out[i] = p * r + 1.0
        bits[i] = (bits[i] << 52) + _ONE
    for i in range(argument.size):
        out[i] = out[i] * spare[i]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_EXACT)
def log_all(argument, out, spare):
    """Write log of `argument` (N,), normal numbers > 0, to `out`; see `exp_all`."""
    bits = spare.view(np.int64)
    for i in range(argument.size):
        spare[i] = argument[i]
    for i in range(argument.size):
        word = bits[i]
        out[i] = float(word >> 52) - 1023.0
        bits[i] = (word & _MANTISSA) | _ONE
    for i in range(argument.size):
        mantissa, exponent = spare[i], out[i]
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
        out[i] = exponent * _LN2_HIGH + (2.0 * f + (f * s * p + exponent * _LN2_LOW))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_EXACT)
def log1p_all(argument, out, spare):
    """Write log(1 + a) of `argument` (N,) >= 0 to `out`, another array; see `exp_all`."""
    for i in range(argument.size):
        out[i] = 1.0 + argument[i]
    log_all(out, out, spare)
    for i in range(argument.size):
        # What rounding took from 1 + a, to first order.
        whole = 1.0 + argument[i]
        out[i] += (argument[i] - (whole - 1.0)) / whole
