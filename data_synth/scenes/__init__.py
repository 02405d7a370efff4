"""Simulated scenes, without pictures.

Random objects that come to rest on a table (`make_scene`) or in and on furniture
(`make_furnished_scene`), solids of given size for hard cases
(the module `staged_solids`), boxes around an arm (`make_reaching_scene`), objects from mesh files
(`read_objects`), and the files of a data set (`write_scene`, `read_ground_truth`).
"""

from . import furniture, staged_solids
from .arm_clearance import ArmClearance, ReachingObstacle, arm_spec, clearance_pairs, frame_views
from .convex_mesh import hull_mesh
from .convex_pieces import hull_volume
from .dataset import (
    DEPTH_FILE,
    LABELS_FILE,
    SCHEMA,
    read_background,
    read_ground_truth,
    read_labels,
    write_scene,
)
from .fixture import BACKGROUND_LEGEND, BackgroundKind, Fixture
from .furnished import make_furnished_scene
from .furnished_scene import (
    COUNT_RANGES,
    MAX_FURNISHED_OBJECTS,
    FurnishedFamily,
    FurnishedOptions,
    FurnishedScene,
)
from .mesh_object import MeshObject
from .object_folder import FolderObject, Split, read_objects, select_half
from .piece_object import PieceObject, read_piece_objects
from .reaching import (
    MAX_BOXES,
    ReachingScene,
    make_reaching_scene,
    passes_base,
    straight_path_is_blocked,
)
from .tabletop import make_scene
from .tabletop_options import MAX_OBJECTS, MIN_OBJECTS, TabletopOptions, ViewOptions
from .tabletop_scene import Family, Table, TabletopObject, TabletopScene
from .tight_places import PLACES, Place
from .viewpoint import MIN_VISIBLE_SHARE, camera_intrinsics, look_at

__all__ = [
    "BACKGROUND_LEGEND",
    "COUNT_RANGES",
    "DEPTH_FILE",
    "LABELS_FILE",
    "MAX_BOXES",
    "MAX_FURNISHED_OBJECTS",
    "MAX_OBJECTS",
    "MIN_OBJECTS",
    "MIN_VISIBLE_SHARE",
    "PLACES",
    "SCHEMA",
    "ArmClearance",
    "BackgroundKind",
    "Family",
    "Fixture",
    "FolderObject",
    "FurnishedFamily",
    "FurnishedOptions",
    "FurnishedScene",
    "MeshObject",
    "PieceObject",
    "Place",
    "ReachingObstacle",
    "ReachingScene",
    "Split",
    "Table",
    "TabletopObject",
    "TabletopOptions",
    "TabletopScene",
    "ViewOptions",
    "arm_spec",
    "camera_intrinsics",
    "clearance_pairs",
    "frame_views",
    "furniture",
    "hull_mesh",
    "hull_volume",
    "look_at",
    "make_furnished_scene",
    "make_reaching_scene",
    "make_scene",
    "passes_base",
    "read_background",
    "read_ground_truth",
    "read_labels",
    "read_objects",
    "read_piece_objects",
    "select_half",
    "staged_solids",
    "straight_path_is_blocked",
    "write_scene",
]
