"""From one depth frame to a described scene."""

from .frame import CameraIntrinsics, DepthFrame
from .io.depth_frame import read_frame, write_frame
from .io.intrinsics import read_intrinsics, write_intrinsics
from .io.point_cloud import read_cloud, write_cloud
from .scene import SUPPORT, PerceiveOptions, Scene, SceneObject, perceive
from .segmentation import Segmentation, SegmentationOptions, SupportPlane, segment
from .superquadric import FitOptions, Superquadric, SuperquadricFit, fit_superquadric

__all__ = [
    "SUPPORT",
    "CameraIntrinsics",
    "DepthFrame",
    "FitOptions",
    "PerceiveOptions",
    "Scene",
    "SceneObject",
    "Segmentation",
    "SegmentationOptions",
    "Superquadric",
    "SuperquadricFit",
    "SupportPlane",
    "fit_superquadric",
    "perceive",
    "read_cloud",
    "read_frame",
    "read_intrinsics",
    "segment",
    "write_cloud",
    "write_frame",
    "write_intrinsics",
]
