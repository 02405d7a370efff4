"""Contact features in NumPy and SciPy: the reference for the compiled kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.tactile import TactileArray


def reference_features(
    pressures: NDArray[np.float64],
    thresholds: NDArray[np.float64],
    array: TactileArray,
    rim: float = 0.0,
) -> dict:
    """Return the features of the largest region. Of equal regions, take the one with more force."""
    active = np.flatnonzero(pressures > thresholds)
    pairs, count = array.neighbours, len(pressures)
    links = csr_matrix((np.ones(len(pairs)), pairs.T), (count, count))[active][:, active]
    count, labels = connected_components(links, directed=False)
    regions = [active[labels == k] for k in range(count)]
    forces = pressures * array.areas
    region = max(regions, key=lambda tactels: (len(tactels), forces[tactels].sum()))
    weights = forces[region]
    normal = weights @ array.normals[region]
    normal /= np.linalg.norm(normal)
    centre = weights @ array.positions[region] / weights.sum()
    tangential = (array.positions[region] - centre) @ rotation_to_normal(normal)
    moments = np.cov(tangential[:, :2].T, aweights=weights, bias=True)
    values, vectors = np.linalg.eigh(moments)
    x, y = vectors[:, 1]
    excess = pressures[region] - thresholds[region]
    saturation = np.minimum(rim * thresholds[region], excess.max())
    counts = np.where(
        excess < saturation, excess / np.where(saturation > 0.0, saturation, 1.0), 1.0
    )
    return {
        "region": region,
        "force": weights.sum(),
        "centre": centre,
        "normal": normal,
        "area": counts @ array.areas[region],
        "angle": np.arctan2(y, x),
        "confidence": (values[1] - values[0]) / max(values.sum(), 1e-300),
        "border_share": weights[array.border[region]].sum() / weights.sum(),
    }


def rotation_to_normal(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smallest rotation (3, 3) that maps z to the normal."""
    axis = np.cross([0.0, 0.0, 1.0], normal)
    length = np.linalg.norm(axis)
    if length == 0.0:
        return np.eye(3)
    return Rotation.from_rotvec(axis / length * np.arctan2(length, normal[2])).as_matrix()
