"""Depth and colour images of scenes.

Renderers by OpenGL and by ray casting, the noise of a depth camera, models of four kinds of
cameras, a synthetic camera, and images of scenes that are given object by object (`StagedScene`).
"""

from .depth_noise import DepthNoise, add_depth_noise, add_dex_noise, axial_sigma
from .depth_renderer import Backend, open_renderer, render_scene
from .depth_sensor import SENSORS, DepthSensor, SensorName, sensor_of
from .gl_probe import gl_fault, gl_module
from .gl_renderer import GlRenderer
from .rendered_view import DepthRenderer, RenderedView
from .scene_frame import capture, render_frame
from .staged_scene import (
    StagedObject,
    StagedScene,
    StagedView,
    noise_at_one_metre,
    render_staged,
    staged_frame,
)

__all__ = [
    "SENSORS",
    "Backend",
    "DepthNoise",
    "DepthRenderer",
    "DepthSensor",
    "GlRenderer",
    "RenderedView",
    "SensorName",
    "StagedObject",
    "StagedScene",
    "StagedView",
    "add_depth_noise",
    "add_dex_noise",
    "axial_sigma",
    "capture",
    "gl_fault",
    "gl_module",
    "noise_at_one_metre",
    "open_renderer",
    "render_frame",
    "render_scene",
    "render_staged",
    "sensor_of",
    "staged_frame",
]
