"""Segmentation of one depth frame into objects, without object models or training data.

:func:`segment` takes a :class:`~eyehand.perception.DepthFrame` and returns a
:class:`Segmentation`. Its labels have the frame's size.

>>> import numpy as np
>>> from eyehand.perception import CameraIntrinsics, DepthFrame
>>> from eyehand.perception.segmentation import SegmentationOptions, segment
>>> depth = np.full((120, 160), 0.8, np.float32)  # a table viewed from above
>>> depth[40:80, 60:100] = 0.7  # a box of 10 cm height
>>> frame = DepthFrame(depth, CameraIntrinsics(140.0, 140.0, 79.5, 59.5, 160, 120))
>>> segmentation = segment(frame, SegmentationOptions(max_extent=0.5))
>>> segmentation.count
1
>>> int(segmentation.mask(1).sum())
1596

:meth:`SegmentationOptions.for_budget` selects the options for a time budget. It reads the points
in ``STORED_FRONT``, which ``eyehand chart segmentation --store`` writes in ``FRONT_FORMAT``.
"""

from .container import Container, Wall
from .find_background import find_support
from .frame_checks import MAX_LEVEL_TILT, frame_faults
from .options import FRONT_FORMAT, STORED_FRONT, SegmentationOptions
from .result import Segmentation, SupportPlane
from .scene_warnings import SceneWarning
from .segment import segment
from .unknown_regions import UnknownRegion

__all__ = [
    "FRONT_FORMAT",
    "MAX_LEVEL_TILT",
    "STORED_FRONT",
    "Container",
    "SceneWarning",
    "Segmentation",
    "SegmentationOptions",
    "SupportPlane",
    "UnknownRegion",
    "Wall",
    "find_support",
    "frame_faults",
    "segment",
]
