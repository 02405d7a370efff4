"""From one depth frame to a described scene: support plane, objects, and a solid for each.

Each name loads its module at first use. The solvers and compiled kernels behind `perceive` need
numba and SciPy, which take longer to import than everything else together.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from eyehand.errors import describe_fields

if TYPE_CHECKING:
    from .frame import CameraIntrinsics, DepthFrame
    from .io import (
        read_cloud,
        read_frame,
        read_intrinsics,
        write_cloud,
        write_frame,
        write_intrinsics,
    )
    from .kernel_cache import kernels_are_cached, warm_up
    from .perpendicular import perpendicular_pair
    from .robot_mask import PosedVolumes, mask_points, mask_robot, mask_volumes, volume_extents
    from .scene import (
        SUPPORT,
        PerceiveOptions,
        RegionEvidence,
        Scene,
        SceneObject,
        fit_region,
        perceive,
        region_evidence,
    )
    from .segmentation import (
        Container,
        SceneWarning,
        Segmentation,
        SegmentationOptions,
        SupportPlane,
        UnknownRegion,
        Wall,
        find_support,
        frame_faults,
        segment,
    )
    from .stored_front import FrontFormat, StoredFront
    from .superquadric import FitOptions, FreeSpace, Superquadric, SuperquadricFit, fit_superquadric
    from .thread_pool import map_in_threads, one_blas_thread
    from .visibility import outline, outline_points, view_free_space

__all__ = [
    "SUPPORT",
    "CameraIntrinsics",
    "Container",
    "DepthFrame",
    "FitOptions",
    "FreeSpace",
    "FrontFormat",
    "PerceiveOptions",
    "PosedVolumes",
    "RegionEvidence",
    "Scene",
    "SceneObject",
    "SceneWarning",
    "Segmentation",
    "SegmentationOptions",
    "StoredFront",
    "Superquadric",
    "SuperquadricFit",
    "SupportPlane",
    "UnknownRegion",
    "Wall",
    "find_support",
    "fit_region",
    "fit_superquadric",
    "frame_faults",
    "kernels_are_cached",
    "map_in_threads",
    "mask_points",
    "mask_robot",
    "mask_volumes",
    "one_blas_thread",
    "outline",
    "outline_points",
    "perceive",
    "perpendicular_pair",
    "read_cloud",
    "read_frame",
    "read_intrinsics",
    "region_evidence",
    "segment",
    "view_free_space",
    "volume_extents",
    "warm_up",
    "write_cloud",
    "write_frame",
    "write_intrinsics",
]

_MODULES = (
    *("frame", "perpendicular", "thread_pool", "stored_front", "io", "robot_mask"),
    *("segmentation", "superquadric", "visibility", "object_evidence", "scene", "kernel_cache"),
)
"""Modules that hold the public names, the quickest to import first."""


def __getattr__(name: str) -> object:
    """Import the module of a public name when the name is first used."""
    if name in __all__:
        for module in _MODULES:
            members = vars(import_module(f".{module}", __name__))
            if name in members:
                describe_fields(members[name])
                return globals().setdefault(name, members[name])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
