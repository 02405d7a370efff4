"""Exact depth frames of balls on a table, with their labels."""

import numpy as np

from eyehand.perception import CameraIntrinsics, DepthFrame

CAMERA = CameraIntrinsics(260.0, 260.0, 159.5, 119.5, 320, 240)
UP = np.array([0.0, -0.8, -0.6])
"""Up direction in the camera frame. The camera looks 37 degrees down."""
CAMERA_HEIGHT = 0.6
"""Height of the camera above the table, m."""


def ball_centre(x: float, y: float, radius: float) -> np.ndarray:
    """Return the centre of a ball on the table (3,), m, camera frame."""
    forward = np.array([0.0, -0.6, 0.8])
    return np.array([x, 0.0, 0.0]) + y * forward + (radius - CAMERA_HEIGHT) * UP


def ball_frame(balls, camera=CAMERA, table=True):
    """Return the frame and the labels (0 = table, k = ball k) of balls (x, y, radius), m."""
    rays = camera.rays()
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    distance = np.full(rays.shape[:2], np.inf)
    if table:
        slope = -(rays @ UP)
        distance = np.where(slope > 1e-3, CAMERA_HEIGHT / np.maximum(slope, 1e-3), np.inf)
    labels = np.zeros(distance.shape, np.int32)
    for label, (x, y, radius) in enumerate(balls, start=1):
        centre = ball_centre(x, y, radius)
        middle = rays @ centre
        discriminant = middle**2 - (centre @ centre - radius**2)
        hit = np.where(discriminant > 0, middle - np.sqrt(np.maximum(discriminant, 0.0)), np.inf)
        labels[hit < distance] = label
        distance = np.minimum(distance, hit)
    depth = np.where(distance < 3.0, distance * rays[..., 2], 0.0).astype(np.float32)
    return DepthFrame(depth, camera), labels
