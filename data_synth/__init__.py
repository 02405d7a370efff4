"""The simulated world: random scenes, rendered depth images, a grasping cell and tactile pads.

Each subpackage offers its public names: `scenes` (objects on a table, reaching scenes), `render`
(depth renderers, noise, synthetic camera), `cell` (arm, hands and robot of a grasping cell) and
`pad` (tactile pads). `cell` builds on `render`, and `render` on `scenes`. The names most often
used are here as well.
"""

from eyehand.errors import describe_fields

from .arms import LBR_ARM, PLANAR_ARM, TOOL_SITE, ReachingArm
from .mujoco_import import import_mujoco
from .render import (
    DepthNoise,
    DepthRenderer,
    RenderedView,
    add_depth_noise,
    open_renderer,
    render_frame,
    render_scene,
)
from .scenes import (
    Family,
    FurnishedFamily,
    FurnishedOptions,
    FurnishedScene,
    Table,
    TabletopObject,
    TabletopOptions,
    TabletopScene,
    ViewOptions,
    look_at,
    make_furnished_scene,
    make_scene,
    read_ground_truth,
    read_labels,
    write_scene,
)

__all__ = [
    "LBR_ARM",
    "PLANAR_ARM",
    "TOOL_SITE",
    "DepthNoise",
    "DepthRenderer",
    "Family",
    "FurnishedFamily",
    "FurnishedOptions",
    "FurnishedScene",
    "ReachingArm",
    "RenderedView",
    "Table",
    "TabletopObject",
    "TabletopOptions",
    "TabletopScene",
    "ViewOptions",
    "add_depth_noise",
    "import_mujoco",
    "look_at",
    "make_furnished_scene",
    "make_scene",
    "open_renderer",
    "read_ground_truth",
    "read_labels",
    "render_frame",
    "render_scene",
    "write_scene",
]

describe_fields(*map(globals().get, __all__))
