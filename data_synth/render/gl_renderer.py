"""Depth, labels and colour by MuJoCo's OpenGL renderer, off-screen."""

from __future__ import annotations

import atexit
import contextlib
import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import DeviceError
from eyehand.perception import CameraIntrinsics

from ..mujoco_import import import_mujoco
from .gl_probe import gl_fault, gl_module
from .rendered_view import RenderedView

NEAR_M = 0.02
"""Near plane, m. With it, MuJoCo's reversed floating-point depth is exact to 1e-7 m at 1 m."""

_FAR_COLOUR_M = 60.0
_MAX_GEOMS = 4000


class GlRenderer:
    """Renderer with one OpenGL context, kept for the life of the object.

    One pass renders depth and labels, so they agree in every pixel. `mujoco.Renderer` is not used,
    because it depends on the value of `MUJOCO_GL` when mujoco was first imported.

    Raises
    ------
    DeviceError
        If no context can be opened on this machine.
    """

    def __init__(self) -> None:
        fault = gl_fault()
        module = gl_module()
        if fault or module is None:
            raise DeviceError(f"OpenGL is not available: {fault}")
        self._mujoco = import_mujoco()
        try:
            self._context: Any = importlib.import_module(module).GLContext(64, 64)
        except Exception as error:
            # The exceptions of graphics libraries have no common base class.
            reason = " ".join(str(error).split())
            raise DeviceError(f"OpenGL is not available: {reason}") from error
        self._drawing: Any = None
        self._model: Any = None
        self._scene: Any = None
        # Before mujoco's own exit handler, which closes the display under the context.
        atexit.register(self.close)

    @property
    def name(self) -> str:
        """``gl``."""
        return "gl"

    def close(self) -> None:
        """Free the context; the renderer cannot be used afterwards."""
        atexit.unregister(self.close)
        if self._context is not None:
            self._release_model()
            self._context.free()
            self._context = None

    def render(
        self,
        model: Any,
        data: Any,
        intrinsics: CameraIntrinsics,
        T_world_camera: RigidTransform,
        geom_labels: NDArray,
        *,
        max_range: float,
        colour: bool,
    ) -> RenderedView:
        """Render as described in :class:`DepthRenderer`.

        Raises
        ------
        DeviceError
            If the renderer is closed or the graphics library fails.
        """
        with self._updated_scene(model, data, intrinsics):
            _set_frustum(self._scene, intrinsics, T_world_camera, max_range)
            depth, labels = self._depth_and_labels(intrinsics, geom_labels, max_range)
            picture = None
            if colour:
                _set_frustum(self._scene, intrinsics, T_world_camera, _FAR_COLOUR_M)
                picture = self._picture(intrinsics)
        return RenderedView(depth, labels, picture)

    def photograph(
        self, model: Any, data: Any, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform
    ) -> NDArray[np.uint8]:
        """Render only colours, (H, W, 3) uint8 RGB, in half the time of :meth:`render`.

        Raises
        ------
        DeviceError
            If the renderer is closed or the graphics library fails.
        """
        with self._updated_scene(model, data, intrinsics):
            _set_frustum(self._scene, intrinsics, T_world_camera, _FAR_COLOUR_M)
            return self._picture(intrinsics)

    @contextlib.contextmanager
    def _updated_scene(self, model: Any, data: Any, intrinsics: CameraIntrinsics) -> Iterator[None]:
        """Make the context current, and update the scene with the state."""
        if self._context is None:
            raise DeviceError("the OpenGL renderer is closed: open another")
        mujoco = self._mujoco
        try:
            with self._context.as_current():
                self._load_model(model, intrinsics)
                option, camera = mujoco.MjvOption(), mujoco.MjvCamera()
                every = mujoco.mjtCatBit.mjCAT_ALL
                mujoco.mjv_updateScene(model, data, option, None, camera, every, self._scene)
                yield
        except mujoco.FatalError as error:
            raise DeviceError(f"OpenGL failed to draw: {' '.join(str(error).split())}") from error

    def _load_model(self, model: Any, intrinsics: CameraIntrinsics) -> None:
        """Upload meshes and textures, unless the model is the same as last time."""
        mujoco = self._mujoco
        if self._model is not model:
            self._release_model()
            self._scene = mujoco.MjvScene(model, _MAX_GEOMS)
            self._drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            self._drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
            self._model = model
        wide, high = intrinsics.width, intrinsics.height
        if (self._drawing.offWidth, self._drawing.offHeight) != (wide, high):
            mujoco.mjr_resizeOffscreen(wide, high, self._drawing)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)

    def _release_model(self) -> None:
        if self._drawing is not None:
            with self._context.as_current():
                self._drawing.free()
        self._drawing = self._model = self._scene = None

    def _depth_and_labels(
        self, intrinsics: CameraIntrinsics, geom_labels: NDArray, max_range: float
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        mujoco, scene = self._mujoco, self._scene
        shape = (intrinsics.height, intrinsics.width)
        ids = np.empty((*shape, 3), dtype=np.uint8)
        buffer = np.empty(shape, dtype=np.float32)
        # Colours are segment numbers in these modes, and multisampling is off.
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            scene.flags[flag] = True
        self._draw(intrinsics, ids, buffer)
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            scene.flags[flag] = False
        segment = ids[..., 0].astype(np.int32)
        segment |= ids[..., 1].astype(np.int32) << 8
        segment |= ids[..., 2].astype(np.int32) << 16
        # Segment 0 is the background.
        label_of_segment = np.zeros(scene.ngeom + 1, dtype=np.int32)
        for geom in scene.geoms[: scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                label_of_segment[geom.segid + 1] = geom_labels[geom.objid]
        depth = _metric(buffer, max_range)
        seen = (segment > 0) & (depth <= max_range)
        return np.where(seen, depth, np.float32(0)), np.where(seen, label_of_segment[segment], 0)

    def _picture(self, intrinsics: CameraIntrinsics) -> NDArray[np.uint8]:
        picture = np.empty((intrinsics.height, intrinsics.width, 3), dtype=np.uint8)
        self._draw(intrinsics, picture, None)
        return picture

    def _draw(
        self,
        intrinsics: CameraIntrinsics,
        picture: NDArray[np.uint8],
        depth: NDArray[np.float32] | None,
    ) -> None:
        """Render the scene and read the image, first row at the top."""
        mujoco = self._mujoco
        whole = mujoco.MjrRect(0, 0, intrinsics.width, intrinsics.height)
        mujoco.mjr_render(whole, self._scene, self._drawing)
        mujoco.mjr_readPixels(picture, depth, whole, self._drawing)
        for image in (picture, depth):
            if image is not None:
                image[:] = image[::-1].copy()


def _set_frustum(
    scene: Any, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform, far: float
) -> None:
    """Set the camera's frustum so that its pixel centres match the intrinsics.

    The image's outer borders lie half a pixel outside the first and last pixel centres.
    """
    k = intrinsics
    axes = T_world_camera.rotation.as_matrix()
    left, right = (-0.5 - k.cx) / k.fx, (k.width - 0.5 - k.cx) / k.fx
    top, bottom = (-0.5 - k.cy) / k.fy, (k.height - 0.5 - k.cy) / k.fy
    for camera in scene.camera:
        camera.pos, camera.forward, camera.up = T_world_camera.translation, axes[:, 2], -axes[:, 1]
        camera.orthographic = 0
        camera.frustum_near, camera.frustum_far = NEAR_M, far
        camera.frustum_center = (left + right) / 2 * NEAR_M
        # Half the width, in spite of its name.
        camera.frustum_width = (right - left) / 2 * NEAR_M
        camera.frustum_top, camera.frustum_bottom = -top * NEAR_M, -bottom * NEAR_M


def _metric(buffer: NDArray[np.float32], far: float) -> NDArray[np.float32]:
    """Convert MuJoCo's reversed depth (1 at the near plane, 0 at the far one) to m."""
    near_far = np.float64(np.float32(NEAR_M)) * np.float64(np.float32(far))
    span = np.float64(np.float32(far)) - np.float64(np.float32(NEAR_M))
    return (near_far / (np.float64(np.float32(NEAR_M)) + buffer.astype(np.float64) * span)).astype(
        np.float32
    )
