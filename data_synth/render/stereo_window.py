"""Geometry of matching along a baseline: shadows, and the effect of matching windows."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .depth_noise import MIN_EDGE_STEP, blurred

_MAJORITY, _MAJORITY_SPREAD = 0.42, 0.08
"""Share of the window that the near surface must cover to win, and its variation over the image.
Below one half, because the near surface has more contrast: outlines grow (foreground fattening)."""
_MAJORITY_PX = 4.0
"""Correlation length of that variation."""
_MIN_STEP_PX = 1.0
"""Smaller differences between neighbours may be slopes."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_SHADOW_SLACK_PX = 0.75
"""A surface is hidden if the second view sees a nearer one this far across its place, at least.
Steep surfaces that both see cross by less, because of the size of pixels."""


def shadow(disparity: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return a mask (H, W) of the pixels that the second device on the +x side does not see.

    A point at column u has the column u - d in the second view, where d is its disparity. A point
    is hidden if a point farther right in the first view lies farther left in the second one
    (the ordering constraint, Baker and Binford 1981).

    Parameters
    ----------
    disparity
        (H, W) px; 0 = nothing there.
    """
    columns = np.arange(disparity.shape[1], dtype=np.float32)
    place = np.where(disparity > 0, columns - disparity, np.float32(np.inf))
    leftmost = np.minimum.accumulate(place[:, ::-1], axis=1)[:, ::-1]
    hidden = np.zeros(disparity.shape, bool)
    hidden[:, :-1] = place[:, :-1] > leftmost[:, 1:] + _SHADOW_SLACK_PX
    return hidden & (disparity > 0)


def matched_disparity(
    disparity: NDArray[np.float32], window: int, mixing: float, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return the disparity that windows match, without noise, and where it steps.

    Where the disparities within a window differ by `mixing` at most, the result is their mean,
    which is exact on planes. At larger steps, the near surface wins if it covers enough of the
    window, else the far one.

    Parameters
    ----------
    disparity
        (H, W) px; 0 = nothing there.
    window
        Width of the window, odd, px.
    mixing
        Largest step of disparity that is smoothed, px.
    rng
        Source of randomness.

    Returns
    -------
    matched, edge
        Disparity (H, W), px, and a mask (H, W) of the pixels within half a window of a larger step.
    """
    jump = np.asarray(cv2.morphologyEx(disparity, cv2.MORPH_GRADIENT, _CROSS), np.float32)
    step = (jump > np.maximum(max(mixing, _MIN_STEP_PX), MIN_EDGE_STEP * disparity)).astype(
        np.uint8
    )
    edge = np.asarray(cv2.dilate(step, np.ones((window // 2 | 1, window // 2 | 1), np.uint8))) > 0
    if window <= 1:
        return disparity, edge
    kernel = np.ones((window, window), np.uint8)
    stepped = np.asarray(cv2.dilate(step, kernel)) > 0
    size = (window, window)
    near = np.asarray(cv2.dilate(disparity, kernel), np.float32)
    far = np.asarray(cv2.erode(disparity, kernel), np.float32)
    middle = (near + far) / 2
    on_near = disparity > middle
    share = np.asarray(cv2.boxFilter(on_near.astype(np.float32), -1, size))
    white = rng.standard_normal(disparity.shape, dtype=np.float32)
    near_wins = share > _MAJORITY + _MAJORITY_SPREAD * blurred(white, _MAJORITY_PX)
    # On the winner's own side the disparity is the pixel's own, which keeps its slope.
    chosen = np.where(near_wins, np.where(on_near, disparity, near), disparity)
    chosen = np.where(~near_wins & on_near, far, chosen)
    mean = np.asarray(cv2.blur(disparity, size), np.float32)
    smooth = np.where(near - far <= mixing, mean, disparity)
    return np.where(stepped, chosen, smooth).astype(np.float32, copy=False), edge
