"""The images of one camera, and the renderer protocol."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.perception import CameraIntrinsics


@dataclass(frozen=True)
class RenderedView:
    """Images of one camera without noise. All show the same pixels."""

    depth: NDArray
    """Depth along the optical axis, (H, W) float32, m; 0 where nothing is in range."""
    labels: NDArray
    """Label of the visible geom from `geom_labels`, (H, W) int32; 0 where nothing is in range."""
    colour: NDArray | None
    """(H, W, 3) uint8 RGB, or None if not requested."""
    background: NDArray | None = None
    """Number in `BACKGROUND_LEGEND` of what a pixel without object shows, (H, W) uint8; 0 is an
    object, or nothing in range. None if the scene's parts have no kinds."""


class DepthRenderer(Protocol):
    """A renderer of MuJoCo models. :func:`.depth_renderer.open_renderer` keeps one per process."""

    @property
    def name(self) -> str:
        """Back end: ``gl`` or ``rays``."""
        ...

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
        """Render the MuJoCo geom groups 0 to 2 from a camera pose.

        The value of a pixel is that of the ray through its centre.

        Parameters
        ----------
        model, data
            `mujoco.MjModel` and its `mujoco.MjData` after `mj_forward` or `mj_kinematics`.
        intrinsics
            The camera.
        T_world_camera
            Maps camera coordinates (x right, y down, z forward) to the world.
        geom_labels
            Label of every geom, (ngeom,) int32.
        max_range
            Largest depth with a reading, m.
        colour
            Whether to render colours too.
        """
        ...
