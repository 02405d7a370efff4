"""Row kernels on several threads: each takes a band of rows and the rows around it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..thread_pool import in_threads

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

MIN_ROWS = 32
"""Bands of fewer rows cost more than they save."""


def in_bands(
    kernel: Callable[..., tuple[NDArray, ...]],
    images: Sequence[NDArray],
    overlap: int,
    threads: int,
) -> tuple[NDArray, ...]:
    """Run ``kernel(*images)`` in bands of rows, with the result of one call on whole images.

    Parameters
    ----------
    kernel
        Takes images (H, ...) and returns images of as many rows; row v of the result may depend
        on rows v - overlap to v + overlap only. It runs in parallel only where it releases the
        interpreter's lock (numba: ``nogil``), which costs microseconds where numba's own
        threading layers cost milliseconds on a loaded machine.
    images
        Inputs, all with equally many rows.
    overlap
        Rows on either side that a row's result depends on.
    threads
        Bands, at most.
    """
    rows = images[0].shape[0]
    bands = min(threads, rows // MIN_ROWS)
    if bands < 2:
        return kernel(*images)
    edges = np.linspace(0, rows, bands + 1).round().astype(int)

    def run(k: int) -> tuple[NDArray, ...]:
        first, last = max(edges[k] - overlap, 0), min(edges[k + 1] + overlap, rows)
        results = kernel(*(image[first:last] for image in images))
        return tuple(result[edges[k] - first : edges[k + 1] - first] for result in results)

    parts = in_threads(run, range(bands), bands)
    return tuple(np.concatenate(images) for images in zip(*parts, strict=True))
