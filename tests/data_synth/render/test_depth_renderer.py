"""The depth renderers: both back ends against exact geometry."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import (
    DepthRenderer,
    Table,
    TabletopObject,
    TabletopOptions,
    TabletopScene,
    look_at,
    make_scene,
    open_renderer,
    render_scene,
)
from eyehand.data_synth.render import depth_renderer as depth_renderer_module
from eyehand.data_synth.render import gl_fault
from eyehand.data_synth.scenes.tabletop_scene import solid_volume
from eyehand.errors import DeviceError, InputError
from eyehand.perception import CameraIntrinsics
from eyehand.perception.superquadric import Kind, Superquadric

# Nothing about this camera is symmetric: a swapped axis or half a pixel shows.
CAMERA = CameraIntrinsics(fx=410.0, fy=430.0, cx=171.3, cy=108.6, width=320, height=240)
EYE = (0.45, -0.35, 0.62)
TARGET = (0.02, 0.03, 0.04)
SPHERE_CENTRE = np.array([0.05, -0.04, 0.05])
SPHERE_RADIUS = 0.05


def available_renderers() -> list[DepthRenderer]:
    """Return the ray caster, and the OpenGL renderer where it is available."""
    rays = [open_renderer("rays")]
    return rays if gl_fault() else [*rays, open_renderer("gl")]


def scene_with(*shapes: Superquadric) -> TabletopScene:
    objects = tuple(
        TabletopObject(f"{shape.kind}_{k}", shape, 300 * solid_volume(shape), (0.8, 0.3, 0.2))
        for k, shape in enumerate(shapes)
    )
    table = Table(size=(0.6, 0.5), height=0.0, floor_drop=0.3)
    return TabletopScene(0, "separate", objects, table, CAMERA, look_at(EYE, TARGET))


def ball(centre: NDArray, radius: float) -> Superquadric:
    return Superquadric(
        np.full(3, radius), (1, 1), RigidTransform.from_translation(centre), "sphere"
    )


def exact_view(intrinsics: CameraIntrinsics) -> tuple[NDArray, NDArray]:
    """Return the exact depth and labels of a ball on a table above the floor."""
    pose = look_at(EYE, TARGET)
    rays = intrinsics.rays() @ pose.rotation.as_matrix().T
    eye = pose.translation
    # The table is a slab of 0.03 m. A ray is inside between its last entry and its first exit.
    low, high = np.array([-0.3, -0.25, -0.03]), np.array([0.3, 0.25, 0.0])
    walls = np.stack([(low - eye) / rays, (high - eye) / rays])
    entry, leave = walls.min(axis=0).max(axis=-1), walls.max(axis=0).min(axis=-1)
    depth = np.where(entry < leave, entry, (-0.3 - eye[2]) / rays[..., 2])
    a = np.einsum("...i,...i", rays, rays)
    b = rays @ (SPHERE_CENTRE - eye)
    c = np.sum((SPHERE_CENTRE - eye) ** 2) - SPHERE_RADIUS**2
    hit = b * b - a * c > 0
    to_ball = (b - np.sqrt(np.maximum(b * b - a * c, 0))) / a
    return np.where(hit, to_ball, depth), hit.astype(np.int32)


def shifted(intrinsics: CameraIntrinsics, u: float, v: float) -> CameraIntrinsics:
    return replace(intrinsics, cx=intrinsics.cx + u, cy=intrinsics.cy + v)


def is_smooth(depth: NDArray) -> NDArray:
    """Return a mask of the pixels whose 5x5 neighbourhood lies on one smooth surface."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(depth, 2, mode="edge"), (5, 5))
    return np.ptp(windows, axis=(2, 3)) < 0.03


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
def test_depth_of_plane_and_sphere_is_exact(renderer: DepthRenderer):
    view = render_scene(scene_with(ball(SPHERE_CENTRE, SPHERE_RADIUS)), renderer=renderer)
    depth, labels = exact_view(CAMERA)
    smooth = is_smooth(depth)
    error = np.abs(view.depth - depth)

    assert smooth[labels == 1].sum() > 1000
    assert error[smooth & (labels == 0)].max() < 1e-5
    assert error[smooth & (labels == 1)].max() < 1e-4
    assert np.median(error[labels == 1]) < 2e-5


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
def test_outlines_are_accurate_to_half_pixel(renderer: DepthRenderer):
    view = render_scene(scene_with(ball(SPHERE_CENTRE, SPHERE_RADIUS)), renderer=renderer)
    _, labels = exact_view(CAMERA)
    steps = (-0.5, 0.0, 0.5)
    near = [exact_view(shifted(CAMERA, u, v))[1] for u in steps for v in steps]

    assert np.all(view.labels >= np.min(near, axis=0))
    assert np.all(view.labels <= np.max(near, axis=0))
    # In addition, almost every pixel centre is on the correct side.
    assert np.count_nonzero(view.labels != labels) <= 3


def test_half_pixel_shift_changes_outline():
    """The outline test detects a wrong pixel convention."""
    _, labels = exact_view(CAMERA)
    _, moved = exact_view(shifted(CAMERA, 0.5, 0.5))
    assert np.count_nonzero(labels != moved) > 30


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
@pytest.mark.parametrize(
    ("kind", "semi_axes", "exponents"),
    [
        ("sphere", (0.04, 0.04, 0.04), (1.0, 1.0)),
        ("ellipsoid", (0.05, 0.03, 0.04), (1.0, 1.0)),
        ("cylinder", (0.03, 0.03, 0.06), (0.02, 1.0)),
        ("box", (0.05, 0.02, 0.035), (0.02, 0.02)),
        ("superquadric", (0.05, 0.02, 0.035), (0.4, 1.2)),
    ],
)
def test_labelled_points_lie_on_ground_truth_solid(
    renderer: DepthRenderer,
    kind: Kind,
    semi_axes: tuple[float, float, float],
    exponents: tuple[float, float],
):
    turn = Rotation.from_euler("xyz", [0.4, 0.9, 0.3])
    pose = RigidTransform.from_components([0.03, 0.02, 0.09], turn)
    shape = Superquadric(np.array(semi_axes), exponents, pose, kind)
    scene = scene_with(shape)
    view = render_scene(scene, renderer=renderer, colour=False)
    visible = view.labels == 1
    points = scene.T_world_camera.apply((CAMERA.rays() * view.depth[..., None])[visible])
    local = np.abs(shape.to_local(points)) / shape.semi_axes
    if kind == "box":
        error = np.abs(local.max(axis=1) - 1) * min(semi_axes)
    elif kind == "cylinder":
        radial = np.hypot(local[:, 0], local[:, 1])
        error = np.abs(np.maximum(radial, local[:, 2]) - 1) * min(semi_axes)
    else:
        error = np.abs(shape.distance(points))

    assert visible.sum() > 500
    assert np.percentile(error, 99) < 2.5e-4
    assert np.median(error) < 1e-4


def test_back_ends_agree():
    if gl_fault():
        with pytest.raises(DeviceError, match="OpenGL is not available"):
            open_renderer("gl")
        return
    scene = make_scene(4, TabletopOptions(family="stacked", count_range=(9, 9)))
    gl = render_scene(scene, renderer=open_renderer("gl"))
    rays = render_scene(scene, renderer=open_renderer("rays"))

    assert np.median(np.abs(gl.depth - rays.depth)) < 1e-5
    assert np.mean(gl.labels == rays.labels) > 0.995
    assert set(np.unique(gl.labels)) == set(np.unique(rays.labels)) == set(range(10))
    assert np.mean((gl.depth > 0) == (rays.depth > 0)) > 0.9999
    assert gl.colour is not None
    assert rays.colour is not None
    bright = [picture.mean() for picture in (gl.colour, rays.colour)]
    assert bright[0] == pytest.approx(bright[1], rel=0.15)


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
def test_images_have_documented_types(renderer: DepthRenderer):
    scene = scene_with(ball(SPHERE_CENTRE, SPHERE_RADIUS))
    view = render_scene(scene, renderer=renderer)
    assert (view.depth.dtype, view.depth.shape) == (np.float32, (240, 320))
    assert (view.labels.dtype, view.labels.shape) == (np.int32, (240, 320))
    assert view.colour is not None
    assert (view.colour.dtype, view.colour.shape) == (np.uint8, (240, 320, 3))
    assert render_scene(scene, renderer=renderer, colour=False).colour is None


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
def test_pixels_have_colour_of_their_object(renderer: DepthRenderer):
    red = scene_with(ball(SPHERE_CENTRE, SPHERE_RADIUS))
    view = render_scene(red, renderer=renderer)
    assert view.colour is not None
    mean = view.colour[view.labels == 1].mean(axis=0)
    assert mean[0] > 1.8 * mean[1]
    assert mean[1] > mean[2]


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
def test_depth_beyond_max_range_is_invalid(renderer: DepthRenderer):
    scene = scene_with(ball(SPHERE_CENTRE, SPHERE_RADIUS))
    full = render_scene(scene, renderer=renderer, colour=False)
    cut = render_scene(scene, renderer=renderer, colour=False, max_range=0.8)
    near = full.depth <= 0.8
    assert np.array_equal(cut.depth > 0, near)
    assert np.allclose(cut.depth[near], full.depth[near], atol=1e-6)
    assert not cut.labels[~near].any()


@pytest.mark.parametrize("renderer", available_renderers(), ids=lambda r: r.name)
def test_renderer_supports_several_image_sizes(renderer: DepthRenderer):
    scene = scene_with(ball(SPHERE_CENTRE, SPHERE_RADIUS))
    large = replace(CAMERA, fx=1640.0, fy=1720.0, cx=686.7, cy=435.9, width=1280, height=960)
    for camera in (large, CAMERA):
        view = render_scene(replace(scene, intrinsics=camera), renderer=renderer, colour=False)
        depth, labels = exact_view(camera)
        smooth = is_smooth(depth) & (labels == 0)
        assert np.abs(view.depth - depth)[smooth].max() < 1e-5


def test_missing_graphics_library_is_logged_once_and_rays_are_used(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
):
    monkeypatch.setattr(depth_renderer_module, "gl_fault", lambda: "no driver")
    open_renderer.cache_clear()
    try:
        with caplog.at_level(logging.INFO, logger="eyehand"):
            names = [open_renderer().name, open_renderer().name]
    finally:
        open_renderer.cache_clear()
    assert names == ["rays", "rays"]
    assert len(caplog.records) == 1
    assert "no driver" in caplog.text


def test_unknown_back_end_raises_with_known_names():
    with pytest.raises(InputError, match="auto, gl, rays, got 'vulkan'"):
        open_renderer("vulkan")  # type: ignore[arg-type]  # the invalid name under test


@pytest.mark.parametrize("max_range", [0.0, -1.0, float("nan"), float("inf")])
def test_render_rejects_invalid_max_range(max_range: float):
    with pytest.raises(InputError, match="max_range must be > 0 m"):
        render_scene(scene_with(ball(SPHERE_CENTRE, 0.05)), max_range=max_range)
