"""Depth and colour images of scenes.

Renderers by OpenGL and by ray casting, the noise of a depth camera, a synthetic camera, and images
of scenes that are given object by object (`StagedScene`).
"""

from .depth_noise import DepthNoise, add_depth_noise, axial_sigma
from .depth_renderer import Backend, open_renderer, render_scene
from .gl_probe import gl_fault, gl_module
from .gl_renderer import GlRenderer
from .rendered_view import DepthRenderer, RenderedView
from .staged_scene import (
    StagedObject,
    StagedScene,
    StagedView,
    noise_at_one_metre,
    render_staged,
    staged_frame,
)
from .synthetic_camera import SyntheticCamera, render_frame

__all__ = [
    "Backend",
    "DepthNoise",
    "DepthRenderer",
    "GlRenderer",
    "RenderedView",
    "StagedObject",
    "StagedScene",
    "StagedView",
    "SyntheticCamera",
    "add_depth_noise",
    "axial_sigma",
    "gl_fault",
    "gl_module",
    "noise_at_one_metre",
    "open_renderer",
    "render_frame",
    "render_scene",
    "render_staged",
    "staged_frame",
]
