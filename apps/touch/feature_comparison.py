"""Compare methods for a contact's direction and position on imprints with known ground truth."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.tactile import (
    Calibration,
    FeatureOptions,
    FeatureReader,
    HoughOptions,
    TactileArray,
    TactileImage,
    contact_features,
    contact_region,
    hough_axis,
    long_axis,
)

from .imprints import NOISE, THRESHOLD, Imprint, imprints

HOUGH_ANGLES, HOUGH_SHARES = (36, 90, 180, 360, 720), (0.0, 0.25, 0.5)
"""Numbers of Hough directions, and thresholds of voting tactels as fractions of the peak. The
chapter uses 0: all tactels of the region vote."""
SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5)
"""Thresholds of the centre of pressure as fractions of the peak. 0 is just above the noise."""
BURST, TAKES = 5, 3
"""Number of calls that are timed together, and number of repetitions. The fastest one counts."""
COUNTS_PER_PA = 0.39
"""Slope of the linear calibration with which a complete reading is timed, counts/Pa. 10 kPa nearly
fill 12 bits."""
REST = 100.0
"""Reading of this calibration at rest, counts."""

_Step = Callable[[], float]


@dataclass(frozen=True)
class _Method:
    name: str
    """Name of the row."""
    method: str
    """Name of the method without its number of angles."""
    angles: int | None
    """Number of Hough directions."""
    share: float
    """Threshold of voting tactels as a fraction of the peak."""
    prepare: Callable[[Imprint], _Step]
    """Function that prepares an imprint and returns the function to be timed. The timed function
    returns the direction, rad."""


def direction_rows(array: TactileArray, lines: Sequence[Imprint]) -> list[dict[str, Any]]:
    """Measure the error and the time of each method for a line's direction.

    The time excludes the computation of the contact region.

    Returns
    -------
    list of dict
        One row per method, the default first: median, 95th percentile and rms of the error, and
        the median time over the imprints.
    """
    methods = _methods(array, {id(line): contact_region(line.image, THRESHOLD) for line in lines})
    for method in methods:
        # The first call compiles.
        method.prepare(lines[0])()
    errors: dict[str, list[float]] = {method.name: [] for method in methods}
    times: dict[str, list[float]] = {method.name: [] for method in methods}
    for line in lines:
        for method in methods:
            step = method.prepare(line)
            error = (step() - line.angle + np.pi / 2) % np.pi - np.pi / 2
            errors[method.name].append(abs(float(np.degrees(error))))
            times[method.name].append(_fastest_us(step))
    return [
        {
            "name": method.name,
            "feature": "orientation",
            "method": method.method,
            "angles": method.angles,
            "threshold_pct": 100 * method.share,
            "time_p50_us": round(float(np.median(times[method.name])), 2),
            **error_spread("deg", errors[method.name]),
        }
        for method in methods
    ]


def centre_rows(probes: Sequence[Imprint]) -> list[dict[str, Any]]:
    """Measure the errors of the centre of pressure and of the unweighted centre per threshold."""
    rows = []
    for share in SHARES:
        for method in ("weighted", "binarised"):
            errors = []
            for probe in probes:
                pressures = probe.image.pressures
                threshold = max(THRESHOLD, share * float(pressures.max()))
                image = probe.image
                if method == "binarised":
                    # Any value above the threshold serves.
                    binary = np.where(pressures > threshold, 2 * threshold, 0.0)
                    image = TactileImage(binary, image.array)
                centre = contact_features(image, threshold).centre[:2]
                errors.append(1e3 * float(np.linalg.norm(centre - probe.centre)))
            rows.append(
                {
                    "name": f"centre {method} {100 * share:g} %",
                    "feature": "centre",
                    "method": method,
                    "threshold_pct": 100 * share,
                    **error_spread("mm", errors),
                }
            )
    return rows


def reading_rows(array: TactileArray, lines: Sequence[Imprint]) -> list[dict[str, Any]]:
    """Measure the time from raw counts to features, with both methods for the direction."""
    calibration = _linear_calibration(len(array.positions))
    counts = [REST + COUNTS_PER_PA * np.maximum(line.image.pressures, 0.0) for line in lines]
    raws = [np.clip(np.rint(count), 0, 4095).astype(np.uint16) for count in counts]
    rows = []
    for method in ("moments", "hough"):
        reader = FeatureReader(calibration, array, FeatureOptions(orientation=method))
        reader.read(raws[0])
        times = [_fastest_us(lambda raw=raw, reader=reader: reader.read(raw).force) for raw in raws]
        rows.append(
            {
                "name": f"reading {method}",
                "feature": "all",
                "method": method,
                "time_p50_us": round(float(np.median(times)), 2),
                "time_p99_us": round(float(np.percentile(times, 99)), 2),
            }
        )
    return rows


def lines_and_probes(
    array: TactileArray, count: int, seed: int
) -> tuple[list[Imprint], list[Imprint]]:
    """Generate `count` lines, half of them across the whole pad, and `count` probes."""
    short = imprints(array, "short line", count - count // 2, seed)
    crossing = imprints(array, "crossing line", count // 2, seed)
    return [*short, *crossing], list(imprints(array, "probe", count, seed))


def error_spread(unit: str, errors: Sequence[float]) -> dict[str, float]:
    """Return the median, 95th percentile and root mean square of errors, keyed with the unit."""
    return {
        f"error_p50_{unit}": round(float(np.median(errors)), 4),
        f"error_p95_{unit}": round(float(np.percentile(errors, 95)), 4),
        f"error_rms_{unit}": round(float(np.sqrt(np.mean(np.square(errors)))), 4),
    }


def _methods(array: TactileArray, regions: dict[int, NDArray[np.bool_]]) -> list[_Method]:
    def moments(weighted: bool) -> Callable[[Imprint], _Step]:
        def prepare(line: Imprint) -> _Step:
            region = regions[id(line)]
            x, y = np.ascontiguousarray(array.positions[region, :2].T)
            weights = line.image.pressures[region] if weighted else np.ones(len(x))
            return lambda: long_axis(x, y, weights, len(x))[0]

        return prepare

    def hough(options: HoughOptions) -> Callable[[Imprint], _Step]:
        return lambda line: lambda: hough_axis(line.image, regions[id(line)], options)

    return [
        _Method("moments", "moments", None, 0.0, moments(True)),
        _Method("moments binarised", "moments binarised", None, 0.0, moments(False)),
        *(
            _Method(
                f"hough {angles} angles, above {100 * share:g} %",
                f"hough above {100 * share:g} %",
                angles,
                share,
                hough(HoughOptions(angles=angles, share=share)),
            )
            for share in HOUGH_SHARES
            for angles in HOUGH_ANGLES
        ),
    ]


def _linear_calibration(count: int) -> Calibration:
    pressures = np.tile([0.0, (4095 - REST) / COUNTS_PER_PA], (count, 1))
    raws = np.tile([REST, 4095.0], (count, 1))
    rest, noise = np.full(count, REST), np.full(count, NOISE * COUNTS_PER_PA)
    return Calibration(raws, pressures, rest, noise, np.full(count, 4095.0), np.zeros(count, bool))


def _fastest_us(step: Callable[[], float]) -> float:
    takes = []
    for _ in range(TAKES):
        start = time.perf_counter_ns()
        for _ in range(BURST):
            step()
        takes.append((time.perf_counter_ns() - start) / BURST)
    return 1e-3 * min(takes)
