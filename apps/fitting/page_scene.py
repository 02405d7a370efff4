"""One fitted cloud in a browser's 3D scene: points, solids with their lines, support, camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.perception.superquadric import feature_curves, mesh

from ..bench.chart_style import GREY, INK
from .panel_look import SOLID, SOLID_OPACITY
from .picture_scene import (
    colour_limit_mm,
    picture_views,
    residual_colours,
    residual_to,
    thinned,
    up_direction,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from eyehand.perception import Superquadric

    from .fit_inputs import Cloud

SHOWN_POINTS = 4000
"""More points make sliders lag and show nothing more."""
RESOLUTION = 64
POINT_SIZE = 0.009
"""Side of a point, in half diagonals of the cloud."""
CURVE_PIXELS = 2.5
SUPPORT_REACH = 1.25
"""Half side of the piece of support shown, in half diagonals of the cloud."""
NEARBY = 12.0
"""A camera farther than this, in half diagonals, is shown at this distance, on its ray."""
VIEW_FROM = (-1.0, 0.8, 1.7)
"""Where a person starts to look from: along right, up and front, in half diagonals."""


class PageScene:
    """Draws one cloud with solids under a node of a viser scene, and redraws the solids.

    Coordinates are scaled so that the cloud's half diagonal is 1, about its middle: browsers keep
    single precision and clip what is very near.
    """

    def __init__(self, scene: Any, node: str, cloud: Cloud, place: ArrayLike = (0, 0, 0)) -> None:
        """Draw what does not change: the support and the camera.

        Parameters
        ----------
        scene
            `viser.SceneApi`; typed as Any because viser is loaded only where a page is made.
        node
            Name under which everything is drawn.
        cloud
            What is shown.
        place
            (3,) where its middle goes, in half diagonals.
        """
        self.points = thinned(cloud.points, SHOWN_POINTS)
        low, high = np.percentile(self.points, [0.5, 99.5], axis=0)
        self._middle = 0.5 * (low + high)
        self.reach = max(float(np.linalg.norm(high - low)) / 2, 1e-6)
        self._scene, self._node = scene, node
        scene.add_frame(node, show_axes=False, position=np.asarray(place, dtype=np.float64))
        self._solids: list[tuple[Any, Any]] = []
        self._cloud = scene.add_point_cloud(
            f"{node}/cloud",
            self._shown(self.points),
            np.zeros((len(self.points), 3), np.uint8),
            point_size=POINT_SIZE,
            point_shape="circle",
            point_shading="flat",
            precision="float32",
        )
        self._draw_support(cloud)
        self._draw_camera(cloud)

    def draw(self, parts: Sequence[Superquadric], limit_mm: float | None = None) -> NDArray:
        """Redraw the solids, colour the points by their distance, and return it, (N,), m."""
        _, residuals = residual_to(self.points, parts)
        limit = limit_mm if limit_mm is not None else self.limit_mm(parts)
        self._cloud.colors = np.round(255 * residual_colours(residuals, limit)).astype(np.uint8)
        while len(self._solids) > len(parts):
            for handle in self._solids.pop():
                handle.remove()
        for number, part in enumerate(parts):
            vertices, faces = mesh(part, RESOLUTION)
            vertices = self._shown(vertices).astype(np.float32)
            curves = [self._shown(curve) for curve in feature_curves(part)]
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
                color=_rgb(SOLID),
                opacity=SOLID_OPACITY,
                cast_shadow=False,
                receive_shadow=False,
            )
            edges = self._scene.add_line_segments(
                f"{self._node}/lines {number}",
                lines,
                _rgb(INK),
                thickness=CURVE_PIXELS,
                thickness_units="screen",
            )
            self._solids.append((surface, edges))
        return residuals

    def limit_mm(self, parts: Sequence[Superquadric]) -> float:
        """End of the colour scale that suits the distance to these solids; 0 without any."""
        return colour_limit_mm(residual_to(self.points, parts)[1]) if parts else 0.0

    def show(self, *, cloud: bool, solid: bool) -> None:
        """Show or hide the points and the solids."""
        self._cloud.visible = cloud
        for surface, edges in self._solids:
            surface.visible = edges.visible = solid

    def remove(self) -> None:
        """Take everything out of the scene."""
        self._scene.remove_by_name(self._node)

    def _shown(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return (points - self._middle) / self.reach

    def _draw_support(self, cloud: Cloud) -> None:
        plane = cloud.support_plane
        if plane is None:
            return
        foot = self._middle - (plane[:3] @ self._middle + plane[3]) * plane[:3]
        front, _, _ = picture_views(cloud)
        right, ahead = front.right * self.reach, front.towards * self.reach
        reach = SUPPORT_REACH
        square = [
            foot + x * reach * right + y * reach * ahead
            for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        self._scene.add_mesh_simple(
            f"{self._node}/support",
            self._shown(np.array(square)).astype(np.float32),
            np.array([[0, 2, 1], [0, 3, 2]], np.uint32),
            color=_rgb(GREY),
            opacity=0.18,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _draw_camera(self, cloud: Cloud) -> None:
        if cloud.view_origin is None:
            return
        eye = self._shown(cloud.view_origin)
        away = float(np.linalg.norm(eye))
        if away > NEARBY:
            eye = eye * NEARBY / away
        self._scene.add_icosphere(
            f"{self._node}/camera", radius=0.04, color=_rgb(INK), position=eye
        )
        self._scene.add_label(f"{self._node}/camera/name", "camera")


def starting_camera(cloud: Cloud) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place (3,) to look at the origin from, in half diagonals, and the direction up, (3,)."""
    front, _, _ = picture_views(cloud)
    axes = np.array([front.right, front.up, front.towards])
    return np.array(VIEW_FROM) @ axes, up_direction(cloud)


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue
