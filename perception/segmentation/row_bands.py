"""Run image functions on several threads, each on a band of rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..thread_pool import map_in_threads

MIN_ROWS = 32
"""Minimum rows of a band. The overhead of a smaller band exceeds the time that it saves."""


def run_in_row_bands(
    function: Callable[..., tuple[NDArray, ...]],
    images: Sequence[NDArray],
    overlap: int,
    threads: int,
) -> tuple[NDArray, ...]:
    """Run ``function(*images)`` on bands of rows and join the results.

    Parameters
    ----------
    function
        Takes images (H, ...) and returns images with the same number of rows. Row v of a result
        may depend only on the rows from v - overlap to v + overlap. The bands run in parallel
        only if it releases the interpreter's lock (numba: ``nogil``). Threads of this kind cost
        microseconds; numba's own threading layers cost milliseconds on a loaded machine.
    images
        Arguments of `function`, all with the same number of rows.
    overlap
        Rows on each side that a row of the result depends on.
    threads
        Maximum number of bands.

    Returns
    -------
    tuple of NDArray
        The result of one call on the whole images.
    """
    rows = images[0].shape[0]
    bands = min(threads, rows // MIN_ROWS)
    if bands < 2:
        return function(*images)
    edges = np.linspace(0, rows, bands + 1).round().astype(int)

    def run(k: int) -> tuple[NDArray, ...]:
        first, last = max(edges[k] - overlap, 0), min(edges[k + 1] + overlap, rows)
        results = function(*(image[first:last] for image in images))
        return tuple(result[edges[k] - first : edges[k + 1] - first] for result in results)

    parts = map_in_threads(run, range(bands), bands)
    return tuple(np.concatenate(images) for images in zip(*parts, strict=True))
