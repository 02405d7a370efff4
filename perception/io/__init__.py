"""Readers and writers of the files that perception uses.

Depth frames, point clouds and camera files have one reader each, which chooses the format by the
file's suffix. The other functions are the parts that they share: arrays, images, poses, meshes.
Every reader checks the whole file, and raises `InputError` with the file's name when it is missing,
damaged or of another kind.
"""

from .atomic_write import atomic_write
from .depth_frame import FRAME_SUFFIXES, read_frame, write_frame
from .depth_units import MM_PER_M, metres_from_units
from .input_file import naming, read_bytes
from .intrinsics import (
    CameraFile,
    find_camera_file,
    intrinsics_from_matrix,
    read_camera_file,
    read_intrinsics,
    write_intrinsics,
)
from .mesh import MESH_SUFFIXES, is_closed, read_mesh, sample_triangles
from .npz import read_arrays
from .png import decode_colour, decode_depth, decode_mask, write_png
from .point_cloud import CLOUD_SUFFIXES, is_organised_cloud, read_cloud, write_cloud
from .pose_json import number_from_json, numbers_from_json, pose_from_json, pose_to_json

__all__ = [
    "CLOUD_SUFFIXES",
    "FRAME_SUFFIXES",
    "MESH_SUFFIXES",
    "MM_PER_M",
    "CameraFile",
    "atomic_write",
    "decode_colour",
    "decode_depth",
    "decode_mask",
    "find_camera_file",
    "intrinsics_from_matrix",
    "is_closed",
    "is_organised_cloud",
    "metres_from_units",
    "naming",
    "number_from_json",
    "numbers_from_json",
    "pose_from_json",
    "pose_to_json",
    "read_arrays",
    "read_bytes",
    "read_camera_file",
    "read_cloud",
    "read_frame",
    "read_intrinsics",
    "read_mesh",
    "sample_triangles",
    "write_cloud",
    "write_frame",
    "write_intrinsics",
    "write_png",
]
