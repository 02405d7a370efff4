"""Small random label images with disparity and local planes.

They reach every branch of a kernel with few pixels.
"""

import numpy as np
from numpy.typing import NDArray

from eyehand.perception import CameraIntrinsics
from eyehand.perception.segmentation.local_planes import LocalPlanes
from eyehand.perception.segmentation.working_image import WorkingImage, inverse

NOISE = 1e-3
"""Noise σ of disparity, 1/m."""
BLOCK = 4
"""Side length of the square blocks that make up a random region, px."""


def random_planes(
    seed: int, rows: int = 14, columns: int = 17, count: int = 4, missing: float = 0.15
) -> tuple[NDArray[np.int32], NDArray[np.float32], LocalPlanes]:
    """Return labels 0..count, disparity, and noisy local planes.

    The disparity of each region scatters around one slope. A `missing` share of the pixels has no
    reading. Another tenth of the pixels has no plane.
    """
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, count + 1, (-(-rows // BLOCK), -(-columns // BLOCK)))
    labels = np.kron(coarse, np.ones((BLOCK, BLOCK), int))[:rows, :columns].astype(np.int32)
    v, u = np.indices(labels.shape)
    mean = (1.0 + 0.02 * rng.normal(size=count + 1))[labels]
    along, down = (0.002 * rng.normal(size=(2, count + 1)))[:, labels]
    q = mean + along * u + down * v + 0.001 * rng.normal(size=labels.shape)
    value = q + 0.001 * rng.normal(size=labels.shape)
    q[rng.random(labels.shape) < missing] = 0.0
    value[(q == 0) | (rng.random(labels.shape) < 0.1)] = 0.0
    slopes = np.stack([along, down]) + 0.001 * rng.normal(size=(2, *labels.shape))
    slopes *= value > 0
    rms = np.where(value > 0, 0.002 * rng.random(labels.shape), -1.0)
    planes = (image.astype(np.float32) for image in (value, *slopes, rms))
    labels[q == 0] = 0
    return labels, q.astype(np.float32), LocalPlanes(*planes)


def image_of(q: NDArray[np.float32], camera: CameraIntrinsics | None = None) -> WorkingImage:
    """Return the working image of a disparity image (H, W), without reduction."""
    rows, columns = q.shape
    camera = camera or CameraIntrinsics(20.0, 21.0, columns / 2, rows / 2, columns, rows)
    return WorkingImage(inverse(q), q, camera, noise=NOISE)
