"""The simulated world: tabletop scenes with ground truth, and the depth camera that sees them."""

from .arms import LBR_ARM, PLANAR_ARM
from .render.depth_noise import DepthNoise, add_depth_noise
from .render.depth_renderer import Backend, open_renderer, render_scene
from .render.rendered_view import DepthRenderer, RenderedView
from .render.synthetic_camera import SyntheticCamera, render_frame
from .scenes.dataset import SCHEMA, read_ground_truth, read_labels, write_scene
from .scenes.reaching import ReachingScene, make_reaching_scene
from .scenes.tabletop import make_scene
from .scenes.tabletop_options import TabletopOptions, ViewOptions
from .scenes.tabletop_scene import Family, Table, TabletopObject, TabletopScene
from .scenes.viewpoint import look_at

__all__ = [
    "LBR_ARM",
    "PLANAR_ARM",
    "SCHEMA",
    "Backend",
    "DepthNoise",
    "DepthRenderer",
    "Family",
    "ReachingScene",
    "RenderedView",
    "SyntheticCamera",
    "Table",
    "TabletopObject",
    "TabletopOptions",
    "TabletopScene",
    "ViewOptions",
    "add_depth_noise",
    "look_at",
    "make_reaching_scene",
    "make_scene",
    "open_renderer",
    "read_ground_truth",
    "read_labels",
    "render_frame",
    "render_scene",
    "write_scene",
]
