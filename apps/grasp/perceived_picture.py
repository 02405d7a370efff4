"""A picture of a perceived scene: segments, fitted solids, their names, and the grasp."""

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

TEXT_HEIGHT = 0.021
"""Text height over image width. The text is legible at a third of the size."""
TEXT_BACKGROUND = (25, 25, 28)
TEXT_OFFSET = 2.2
"""Offset of a name below its object, in text heights. Most hands approach from above."""


def perceived_picture(
    frame: DepthFrame,
    scene: Scene,
    plan: GraspPlan | None = None,
    T_world_palm: RigidTransform | None = None,
    *,
    names: bool = True,
    colours: Mapping[int, int] | None = None,
) -> NDArray[np.uint8]:
    """Draw a perceived scene, enlarged, (H', W', 3) uint8 RGB.

    Parameters
    ----------
    frame, scene
        The depth frame and its scene, for example from :func:`~.frame_crop.crop_to_objects`.
    plan
        The grasp to draw.
    T_world_palm
        Pose of the palm; default: the preferred pose of the plan.
    names
        Whether to write the label and the kind of solid below each object.
    colours
        Colour number of each object by its label; default: the label.
    """
    colours = colours or {}
    picture = overlay_picture(frame, _numbered(scene, colours), {}, names=False)
    if plan is not None:
        draw_grasp(picture, frame, plan, T_world_palm)
    if names:
        _name_objects(picture, frame, scene, colours)
    return picture


def _numbered(scene: Scene, numbers: Mapping[int, int]) -> Scene:
    """Return the scene with its labels replaced by the colour numbers."""
    labels = scene.segmentation.labels
    renamed = np.zeros_like(labels)
    for item in scene.objects:
        renamed[labels == item.label] = numbers.get(item.label, item.label)
    objects = tuple(
        replace(item, label=numbers.get(item.label, item.label)) for item in scene.objects
    )
    return replace(scene, objects=objects, segmentation=replace(scene.segmentation, labels=renamed))


def _name_objects(
    picture: NDArray[np.uint8], frame: DepthFrame, scene: Scene, colours: Mapping[int, int]
) -> None:
    height, width = picture.shape[:2]
    zoom = width / frame.depth.shape[1]
    font = cv2.FONT_HERSHEY_DUPLEX
    scale = cv2.getFontScaleFromHeight(font, round(TEXT_HEIGHT * width))
    thick = max(round(TEXT_HEIGHT * width / 16), 1)
    for item in scene.objects:
        rows, columns = np.nonzero(scene.segmentation.labels == item.label)
        if not len(rows):
            continue
        solid = item.fit.superquadric if item.fit else None
        text = f"{item.label} {solid.kind if solid else 'no solid'}"
        (text_width, text_height), base = cv2.getTextSize(text, font, scale, thick)
        left = int(np.clip(np.median(columns) * zoom - text_width / 2, 8, width - text_width - 8))
        foot = int(
            np.clip(
                rows.max() * zoom + TEXT_OFFSET * text_height, text_height + 8, height - base - 8
            )
        )
        corners = (left - 8, foot - text_height - 8), (left + text_width + 8, foot + base + 4)
        cv2.rectangle(picture, *corners, TEXT_BACKGROUND, cv2.FILLED)
        shade = colour_of(colours.get(item.label, item.label))
        red, green, blue = (0.35 * 255 + 0.65 * shade).astype(int).tolist()
        cv2.putText(
            picture, text, (left, foot), font, scale, (red, green, blue), thick, cv2.LINE_AA
        )
