"""Recorded slip of the BioTac SP data set: windows, features, and their classification.

The recordings are those of Zapata-Impata, Gil and Torres (Sensors 19:523, 2019): 24 electrodes at
about 100 Hz, one of seven classes for each recording.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax
from scipy.stats import rankdata

from eyehand.errors import InputError

from .slip_network import train_network

CLASSES = ("n", "e", "s", "w", "cw", "aw", "t")
"""Folders: slip in four directions, two rotations, and touch without slip."""
TOUCH = CLASSES.index("t")
SETS = {
    "basic": ("case", "hd", "sponge", "pen"),
    "solids": ("bottle", "cardboard"),
    "small": ("brush", "screw"),
    "textures": ("striped", "strippes", "bubbles", "plate"),
}
"""Sets of objects, as in the publication; one file has a misspelt name."""
TRAINED = "basic"
"""The set that the network is trained on."""
WINDOW = 5
"""Readings in a window: 50 ms."""
ELECTRODES = 24


@dataclass(frozen=True)
class SlipWindows:
    """M windows of recorded readings."""

    readings: NDArray[np.float64]
    """(M, WINDOW, ELECTRODES), counts."""
    labels: NDArray[np.int64]
    """(M,), index of the class in `CLASSES`."""
    sets: NDArray[np.str_]
    """(M,), name of the object set."""


def load_windows(folder: Path) -> SlipWindows:
    """Read all recordings below a folder with one folder per class.

    Raises
    ------
    InputError
        If a set or class has no recording, or a file is not a table of 24 columns.
    """
    of_object = {name: group for group, names in SETS.items() for name in names}
    readings, labels, sets = [], [], []
    for label, name in enumerate(CLASSES):
        for file in sorted((folder / name).glob("*.csv")):
            group = of_object.get(file.stem.rstrip("0123456789"))
            if group is None:
                continue
            windows = _read(file)
            readings.append(windows)
            labels += [label] * len(windows)
            sets += [group] * len(windows)
    missing = {(g, k) for g in SETS for k in range(len(CLASSES))} - set(
        zip(sets, labels, strict=True)
    )
    if missing:
        group, label = min(missing)
        raise InputError(
            f"{folder} must hold one folder of recordings per class ({', '.join(CLASSES)}) with "
            f"objects of all sets, got none of class {CLASSES[label]} of the set {group}"
        )
    return SlipWindows(np.concatenate(readings), np.array(labels), np.array(sets))


def _read(file: Path) -> NDArray[np.float64]:
    try:
        table = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
    except (ValueError, OSError) as error:
        raise InputError(f"{file} must be a table of numbers, got: {error}") from None
    if table.shape[1] != ELECTRODES or not np.isfinite(table).all():
        raise InputError(
            f"{file} must have {ELECTRODES} columns of finite numbers, got {table.shape[1]}"
        )
    count = len(table) // WINDOW
    return table[: count * WINDOW].reshape(count, WINDOW, ELECTRODES)


def fourier_features(readings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the amplitudes of all frequencies but 0 in each window, (M, 2 ELECTRODES).

    These are the features of the chapter (section 3.1). They do not depend on the offset.
    """
    return np.abs(np.fft.rfft(readings, axis=1)[:, 1:]).reshape(len(readings), -1)


def mean_features(readings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of each electrode, (M, ELECTRODES): how the fingertip is deformed."""
    return readings.mean(axis=1)


def fourier_and_mean(readings: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the amplitudes and the means, (M, 3 ELECTRODES)."""
    return np.hstack([fourier_features(readings), mean_features(readings)])


FEATURES: dict[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
    "Fourier (chapter)": fourier_features,
    "mean": mean_features,
    "Fourier and mean": fourier_and_mean,
}
"""Feature sets by name."""


def slip_rows(windows: SlipWindows, seeds: Sequence[int]) -> list[dict[str, float | str]]:
    """Train on one set of objects, test on each other, and return one row per feature set."""
    rows = []
    for name, features in FEATURES.items():
        values = features(windows.readings)
        train = windows.sets == TRAINED
        row: dict[str, float | str] = {"name": name}
        scores = [
            train_network(values[train], windows.labels[train], s, classes=len(CLASSES))(values)
            for s in seeds
        ]
        for group in SETS:
            rows_of = windows.sets == group
            truth = windows.labels[rows_of]
            right = [100 * np.mean(s[rows_of].argmax(axis=1) == truth) for s in scores]
            areas = [slip_auc(s[rows_of], truth) for s in scores]
            row[f"{group}_right_pct"] = float(np.mean(right))
            row[f"{group}_auc"] = float(np.mean(areas))
        rows.append(row)
    return rows


def slip_auc(scores: NDArray[np.float64], labels: NDArray[np.int64]) -> float:
    """Return the area under the curve of slip against no slip, from class scores (M, 7)."""
    slips = labels != TOUCH
    ranks = rankdata(-softmax(scores, axis=1)[:, TOUCH])
    count = int(slips.sum())
    return float(
        (ranks[slips].sum() - count * (count + 1) / 2) / (count * max(len(labels) - count, 1))
    )
