"""A table with balls, ray cast in a few lines: an exact frame with exact labels."""

import numpy as np

from eyehand.perception import CameraIntrinsics, DepthFrame

CAMERA = CameraIntrinsics(260.0, 260.0, 159.5, 119.5, 320, 240)
UP = np.array([0.0, -0.8, -0.6])
"""Up in the camera's frame: the camera looks down by 37 degrees."""
HEIGHT = 0.6
"""Of the camera over the table, m."""


def on_table(x: float, y: float, radius: float) -> np.ndarray:
    """Centre in the camera's frame of a ball that touches the table."""
    forward = np.array([0.0, -0.6, 0.8])
    return np.array([x, 0.0, 0.0]) + y * forward + (radius - HEIGHT) * UP


def ball_frame(balls, camera=CAMERA, table=True):
    """Frame and labels (0 = table, k = ball k) of (x, y, radius) balls on a table."""
    rays = camera.rays()
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    distance = np.full(rays.shape[:2], np.inf)
    if table:
        slope = -(rays @ UP)
        distance = np.where(slope > 1e-3, HEIGHT / np.maximum(slope, 1e-3), np.inf)
    labels = np.zeros(distance.shape, np.int32)
    for number, (x, y, radius) in enumerate(balls, start=1):
        centre = on_table(x, y, radius)
        along = rays @ centre
        square = along**2 - (centre @ centre - radius**2)
        hit = np.where(square > 0, along - np.sqrt(np.maximum(square, 0.0)), np.inf)
        labels[hit < distance] = number
        distance = np.minimum(distance, hit)
    depth = np.where(distance < 3.0, distance * rays[..., 2], 0.0).astype(np.float32)
    return DepthFrame(depth, camera), labels
