"""What was seen in one picture: segments, fitted solids, their names, and the chosen grasp."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import cv2
import numpy as np

from ..scene_picture import colour_of, overlay_picture
from .grasp_glyph import draw_grasp

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.grasping import GraspPlan
    from eyehand.perception import DepthFrame, Scene

LETTERS = 0.021
"""Height of a name's letters, as a share of the picture's width: legible at a third of it."""
NAME_GROUND = (25, 25, 28)
OFF = 2.2
"""From the foot of an object to the foot of its name, in heights of letters: below it, as hands
mostly come from above."""


def look_picture(
    frame: DepthFrame,
    scene: Scene,
    plan: GraspPlan | None = None,
    T_world_palm: RigidTransform | None = None,
    *,
    names: bool = True,
    colours: Mapping[int, int] | None = None,
) -> NDArray[np.uint8]:
    """Draw a look, (H', W', 3) uint8 RGB, enlarged.

    Parameters
    ----------
    frame, scene
        What was seen; see :func:`~.closeup.closeup`.
    plan
        The grasp to draw.
    T_world_palm
        Where the palm was then; without it, where the plan prefers it.
    names
        Whether each object's number and solid stand at it.
    colours
        Number of each object's colour by its label; without it, the label.
    """
    colours = colours or {}
    picture = overlay_picture(frame, _numbered(scene, colours), {}, names=False)
    if plan is not None:
        draw_grasp(picture, frame, plan, T_world_palm)
    if names:
        _name_objects(picture, frame, scene, colours)
    return picture


def _numbered(scene: Scene, numbers: Mapping[int, int]) -> Scene:
    """Give the scene with its objects' labels replaced."""
    labels = scene.segmentation.labels
    renamed = np.zeros_like(labels)
    for item in scene.objects:
        renamed[labels == item.label] = numbers.get(item.label, item.label)
    objects = tuple(replace(one, label=numbers.get(one.label, one.label)) for one in scene.objects)
    return replace(scene, objects=objects, segmentation=replace(scene.segmentation, labels=renamed))


def _name_objects(
    picture: NDArray[np.uint8], frame: DepthFrame, scene: Scene, colours: Mapping[int, int]
) -> None:
    height, width = picture.shape[:2]
    zoom = width / frame.depth.shape[1]
    font = cv2.FONT_HERSHEY_DUPLEX
    scale = cv2.getFontScaleFromHeight(font, round(LETTERS * width))
    thick = max(round(LETTERS * width / 16), 1)
    for item in scene.objects:
        rows, columns = np.nonzero(scene.segmentation.labels == item.label)
        if not len(rows):
            continue
        solid = item.fit.superquadric if item.fit else None
        text = f"{item.label} {solid.kind if solid else 'no solid'}"
        (wide, high), base = cv2.getTextSize(text, font, scale, thick)
        left = int(np.clip(np.median(columns) * zoom - wide / 2, 8, width - wide - 8))
        foot = int(np.clip(rows.max() * zoom + OFF * high, high + 8, height - base - 8))
        corners = (left - 8, foot - high - 8), (left + wide + 8, foot + base + 4)
        cv2.rectangle(picture, *corners, NAME_GROUND, cv2.FILLED)
        shade = colour_of(colours.get(item.label, item.label))
        red, green, blue = (0.35 * 255 + 0.65 * shade).astype(int).tolist()
        cv2.putText(
            picture, text, (left, foot), font, scale, (red, green, blue), thick, cv2.LINE_AA
        )
