"""Draw a fitted cloud in a viser scene: points, solids with edges, support, camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench.chart_style import GREY, INK
from ..drawn_solids import solid_curves, solid_mesh
from .panel_style import SOLID, SOLID_OPACITY
from .picture_scene import (
    colour_limit_mm,
    picture_views,
    residual_colours,
    residual_to,
    rgb,
    thinned,
    up_direction,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from eyehand.perception import Superquadric
    from eyehand.perception.superquadric import Vessel

    from .fit_inputs import Cloud

MAX_POINTS = 4000
"""Maximum number of points. More make the sliders slow and show no more detail."""
RESOLUTION = 64
POINT_SIZE = 0.009
"""Side of a point, relative to the half diagonal of the cloud."""
CURVE_PIXELS = 2.5
SUPPORT_REACH = 1.25
"""Half side of the drawn support plane, relative to the half diagonal of the cloud."""
MAX_CAMERA_DISTANCE = 12.0
"""Distance of the drawn camera at most, in half diagonals. A farther one is moved along its ray."""
VIEW_FROM = (-1.0, 0.8, 1.7)
"""Initial viewpoint: right, up and front coordinate, in half diagonals."""


class PageScene:
    """One cloud with solids under a node of a viser scene; the solids can be redrawn.

    Coordinates are scaled about the middle of the cloud so that its half diagonal is 1, because
    browsers use single precision and clip near geometry.
    """

    def __init__(self, scene: Any, node: str, cloud: Cloud, place: ArrayLike = (0, 0, 0)) -> None:
        """Draw the fixed parts: points, support and camera.

        Parameters
        ----------
        scene
            `viser.SceneApi`. Its type is Any because viser is imported only to make a page.
        node
            Name of the node that holds everything.
        cloud
            Cloud to show.
        place
            Position (3,) of the middle of the cloud, in half diagonals.
        """
        self.points = thinned(cloud.points, MAX_POINTS)
        low, high = np.percentile(self.points, [0.5, 99.5], axis=0)
        self._middle = 0.5 * (low + high)
        self.reach = max(float(np.linalg.norm(high - low)) / 2, 1e-6)
        self._scene, self._node = scene, node
        scene.add_frame(node, show_axes=False, position=np.asarray(place, dtype=np.float64))
        self._solids: list[tuple[Any, Any]] = []
        self._cloud = scene.add_point_cloud(
            f"{node}/cloud",
            self._scaled(self.points),
            np.zeros((len(self.points), 3), np.uint8),
            point_size=POINT_SIZE,
            point_shape="circle",
            point_shading="flat",
            precision="float32",
        )
        self._draw_support(cloud)
        self._draw_camera(cloud)

    def draw(
        self, parts: Sequence[Superquadric | Vessel], limit_mm: float | None = None
    ) -> NDArray:
        """Redraw the solids, colour the points by distance; return the distances, (N,), m."""
        _, residuals = residual_to(self.points, parts)
        limit = limit_mm if limit_mm is not None else self.limit_mm(parts)
        self._cloud.colors = np.round(255 * residual_colours(residuals, limit)).astype(np.uint8)
        while len(self._solids) > len(parts):
            for handle in self._solids.pop():
                handle.remove()
        for number, part in enumerate(parts):
            vertices, faces = solid_mesh(part, RESOLUTION)
            vertices = self._scaled(vertices).astype(np.float32)
            curves = [self._scaled(curve) for curve in solid_curves(part)]
            lines = np.concatenate(
                [np.stack([curve[:-1], curve[1:]], axis=1) for curve in curves]
            ).astype(np.float32)
            if number < len(self._solids):
                surface, edges = self._solids[number]
                surface.vertices, edges.points = vertices, lines
                continue
            surface = self._scene.add_mesh_simple(
                f"{self._node}/solid {number}",
                vertices,
                faces.astype(np.uint32),
                color=rgb(SOLID),
                opacity=SOLID_OPACITY,
                cast_shadow=False,
                receive_shadow=False,
            )
            edges = self._scene.add_line_segments(
                f"{self._node}/lines {number}",
                lines,
                rgb(INK),
                thickness=CURVE_PIXELS,
                thickness_units="screen",
            )
            self._solids.append((surface, edges))
        return residuals

    def limit_mm(self, parts: Sequence[Superquadric | Vessel]) -> float:
        """Return a suitable end of the colour scale for these solids, mm; 0 without solids."""
        return colour_limit_mm(residual_to(self.points, parts)[1]) if parts else 0.0

    def show(self, *, cloud: bool, solid: bool) -> None:
        """Show or hide the points and the solids."""
        self._cloud.visible = cloud
        for surface, edges in self._solids:
            surface.visible = edges.visible = solid

    def remove(self) -> None:
        """Remove everything from the scene."""
        self._scene.remove_by_name(self._node)

    def _scaled(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return (points - self._middle) / self.reach

    def _draw_support(self, cloud: Cloud) -> None:
        plane = cloud.support_plane
        if plane is None:
            return
        foot = self._middle - (plane[:3] @ self._middle + plane[3]) * plane[:3]
        front, _, _ = picture_views(cloud)
        right, ahead = front.right * self.reach, front.towards * self.reach
        square = [
            foot + x * SUPPORT_REACH * right + y * SUPPORT_REACH * ahead
            for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        self._scene.add_mesh_simple(
            f"{self._node}/support",
            self._scaled(np.array(square)).astype(np.float32),
            np.array([[0, 2, 1], [0, 3, 2]], np.uint32),
            color=rgb(GREY),
            opacity=0.18,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _draw_camera(self, cloud: Cloud) -> None:
        if cloud.view_origin is None:
            return
        eye = self._scaled(cloud.view_origin)
        away = float(np.linalg.norm(eye))
        if away > MAX_CAMERA_DISTANCE:
            eye = eye * MAX_CAMERA_DISTANCE / away
        self._scene.add_icosphere(f"{self._node}/camera", radius=0.04, color=rgb(INK), position=eye)
        self._scene.add_label(f"{self._node}/camera/name", "camera")


def starting_camera(cloud: Cloud) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the initial camera position (3,), in half diagonals, and the up direction (3,)."""
    front, _, _ = picture_views(cloud)
    axes = np.array([front.right, front.up, front.towards])
    return np.array(VIEW_FROM) @ axes, up_direction(cloud)
