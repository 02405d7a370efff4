"""From one depth frame to a described scene."""

from .cloud_io import read_cloud, write_cloud
from .frame import CameraIntrinsics, DepthFrame
from .frame_io import read_frame, write_frame
from .intrinsics_io import read_intrinsics, write_intrinsics
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
