"""Simulated scenes, without pictures.

Random objects that come to rest on a table (`make_scene`), solids of given size for hard cases
(`box`, `mug`, …), boxes around an arm (`make_reaching_scene`), objects from mesh files
(`read_objects`), and the files of a data set (`write_scene`, `read_ground_truth`).
"""

from .arm_clearance import ArmClearance, ReachingObstacle, arm_spec, clearance_pairs
from .convex_mesh import hull_mesh
from .dataset import DEPTH_FILE, LABELS_FILE, SCHEMA, read_ground_truth, read_labels, write_scene
from .mesh_object import MeshObject
from .object_folder import FolderObject, read_objects
from .reaching import MAX_BOXES, ReachingScene, make_reaching_scene, straight_path_is_blocked
from .staged_solids import (
    StagedSolid,
    Tube,
    ball,
    bowl,
    box,
    cylinder,
    mug,
    rod,
    superquadric,
    tapered_box,
)
from .tabletop import make_scene
from .tabletop_options import MAX_OBJECTS, MIN_OBJECTS, TabletopOptions, ViewOptions
from .tabletop_scene import Family, Table, TabletopObject, TabletopScene
from .tabletop_spec import tabletop_spec
from .viewpoint import camera_intrinsics, look_at

__all__ = [
    "DEPTH_FILE",
    "LABELS_FILE",
    "MAX_BOXES",
    "MAX_OBJECTS",
    "MIN_OBJECTS",
    "SCHEMA",
    "ArmClearance",
    "Family",
    "FolderObject",
    "MeshObject",
    "ReachingObstacle",
    "ReachingScene",
    "StagedSolid",
    "Table",
    "TabletopObject",
    "TabletopOptions",
    "TabletopScene",
    "Tube",
    "ViewOptions",
    "arm_spec",
    "ball",
    "bowl",
    "box",
    "camera_intrinsics",
    "clearance_pairs",
    "cylinder",
    "hull_mesh",
    "look_at",
    "make_reaching_scene",
    "make_scene",
    "mug",
    "read_ground_truth",
    "read_labels",
    "read_objects",
    "rod",
    "straight_path_is_blocked",
    "superquadric",
    "tabletop_spec",
    "tapered_box",
    "write_scene",
]
