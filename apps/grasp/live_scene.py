"""A simulated cell in a browser's 3D scene: robot, objects, and what was seen of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.perception.superquadric import feature_curves, mesh

from ..scene_json import fit_parts
from ..scene_picture import colour_of
from .body_meshes import body_meshes
from .grasp_glyph import preferred_palm

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import GraspPlan
    from eyehand.perception import DepthFrame, Scene, Superquadric

EYE, LOOKED_AT = (0.62, 0.74, 0.62), (0.1, -0.14, 0.12)
"""Where a person starts to look from, and to, m."""
CLOUD_STEP = 3
"""Every so manieth row and column of a depth image becomes a point: a page draws 30 000 well."""
FLOOR_DROP = 0.1
"""Points farther below the table's top than this are not shown, m."""
POINT = 0.0022
"""Side of a point, m."""
UNLABELLED = (150, 155, 163)
RESOLUTION = 40
OPACITY = 0.45
"""Of a fitted solid: the object shows through."""
GRASP_AXES = 0.07
"""Length of the axes at a chosen grasp, m."""


class LiveScene:
    """Draws a cell into a viser scene, and moves what moves.

    Parameters
    ----------
    scene
        `viser.SceneApi`; typed as Any because viser is loaded only where a page is made.
    robot
        The simulated robot.
    """

    def __init__(self, scene: Any, robot: SimRobot) -> None:
        self._scene, self._data = scene, robot.data
        self._bodies = {
            body: scene.add_mesh_trimesh(f"/cell/{body}", shape)
            for body, shape in body_meshes(robot.model).items()
        }
        self._looks = 0
        self._look: Any = None
        self._grasp: Any = None
        self._clouds: dict[int, Any] = {}
        self._solids: dict[int, list[Any]] = {}
        self._colours: dict[int, NDArray[np.uint8]] = {}
        self._show_cloud = self._show_solids = True
        self.move()

    def move(self) -> None:
        """Put every body where it is now."""
        for body, handle in self._bodies.items():
            handle.position = self._data.xpos[body].copy()
            handle.wxyz = self._data.xquat[body].copy()

    def see(
        self,
        frame: DepthFrame,
        scene: Scene,
        plan: GraspPlan | None = None,
        colours: Mapping[int, int] | None = None,
    ) -> None:
        """Draw a look: its points by object, the solids, and the grasp to come.

        Parameters
        ----------
        frame, scene
            The depth image and what was seen in it.
        plan
            The grasp; none where nothing is picked.
        colours
            Number of each object's colour by its label; without it, the label.
        """
        self._forget()
        numbers = colours or {}
        self._colours = {
            one.label: colour_of(numbers.get(one.label, one.label)) for one in scene.objects
        }
        # Nodes of one look hang from one that is named like no other: nothing of the look before
        # is taken for it, in whatever order a browser hears of both.
        self._looks += 1
        node = f"/look{self._looks}"
        self._look = self._scene.add_frame(node, show_axes=False)
        self._draw_points(node, frame, scene)
        for item in scene.objects:
            parts = fit_parts(item.fit) if item.fit else ()
            self._solids[item.label] = [
                handle
                for number, part in enumerate(parts)
                for handle in self._draw_solid(f"{node}/{item.label}/{number}", item.label, part)
            ]
        if plan is not None and plan.geometry is not None:
            palm = preferred_palm(plan)
            self._grasp = self._scene.add_frame(
                f"{node}/grasp",
                axes_length=GRASP_AXES,
                axes_radius=0.03 * GRASP_AXES,
                position=palm.translation,
                wxyz=palm.rotation.as_quat(scalar_first=True),
            )

    def taken(self, label: int) -> None:
        """Take away what was seen of an object, and the grasp: the object is in the hand."""
        gone = [*self._solids.pop(label, []), self._clouds.pop(label, None), self._grasp]
        self._grasp = None
        for handle in gone:
            if handle is not None:
                handle.remove()

    def show(self, *, cloud: bool, solids: bool) -> None:
        """Show or hide the points and the fitted solids."""
        self._show_cloud, self._show_solids = cloud, solids
        # Copies: the page asks from a thread of its own.
        for handle in list(self._clouds.values()):
            handle.visible = cloud
        for handle in [one for handles in list(self._solids.values()) for one in handles]:
            handle.visible = solids

    def _draw_points(self, node: str, frame: DepthFrame, scene: Scene) -> None:
        """Draw the points of each object, and with label 0 those of none."""
        labels = scene.segmentation.labels
        grid = slice(None, None, CLOUD_STEP), slice(None, None, CLOUD_STEP)
        valid = frame.valid[grid]
        points = frame.points()[grid][valid].astype(np.float64)
        if frame.T_world_camera is not None:
            points = frame.T_world_camera.apply(points)
        seen = np.zeros(len(points), dtype=np.int64)
        if labels.shape == frame.depth.shape:
            seen = labels[grid][valid]
        known = [label for label in self._colours if (seen == label).any()]
        seen = np.where(np.isin(seen, known), seen, 0)
        # The floor is far away, and says nothing.
        near = points[:, 2] > -FLOOR_DROP
        for label in (0, *known):
            shown = near & (seen == label)
            if not shown.any():
                continue
            shade = self._colours.get(label, np.array(UNLABELLED, np.uint8))
            self._clouds[label] = self._scene.add_point_cloud(
                f"{node}/cloud{label}",
                points[shown].astype(np.float32),
                np.tile(shade, (int(shown.sum()), 1)),
                point_size=POINT,
                visible=self._show_cloud,
            )

    def _draw_solid(self, node: str, label: int, part: Superquadric) -> list[Any]:
        colour = tuple(self._colours[label].tolist())
        vertices, faces = mesh(part, RESOLUTION)
        lines = np.concatenate(
            [np.stack([curve[:-1], curve[1:]], axis=1) for curve in feature_curves(part)]
        )
        return [
            self._scene.add_mesh_simple(
                f"{node}/surface",
                vertices.astype(np.float32),
                faces.astype(np.uint32),
                color=colour,
                opacity=OPACITY,
                cast_shadow=False,
                receive_shadow=False,
                visible=self._show_solids,
            ),
            self._scene.add_line_segments(
                f"{node}/lines",
                lines.astype(np.float32),
                colour,
                thickness=2.0,
                thickness_units="screen",
                visible=self._show_solids,
            ),
        ]

    def _forget(self) -> None:
        if self._look is not None:
            self._look.remove()
        self._look = self._grasp = None
        self._clouds, self._solids = {}, {}
