"""Model-free segmentation of one depth frame."""

from .options import SegmentationOptions
from .result import Segmentation, SupportPlane
from .segment import segment

__all__ = ["Segmentation", "SegmentationOptions", "SupportPlane", "segment"]
