"""The 3D scene of the live page: robot, objects, depth points and fitted solids."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.perception.superquadric import feature_curves, mesh

from ..fitting.viewer_page import draw_lines, draw_mesh, draw_points
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

CAMERA_POSITION, CAMERA_TARGET = (0.62, 0.74, 0.62), (0.1, -0.14, 0.12)
"""Initial position and target of the page's camera, m."""
CLOUD_STEP = 3
"""Step between the drawn rows and columns of a depth image. A page can draw 30 000 points."""
MAX_DEPTH_BELOW_TABLE = 0.1
"""Maximum distance of a shown point below the table top, m. The floor is not shown."""
POINT_SIZE = 0.0022
"""Size of a point, m."""
UNLABELLED = (150, 155, 163)
RESOLUTION = 40
OPACITY = 0.45
"""Opacity of a fitted solid. The object shows through."""
GRASP_AXES = 0.07
"""Length of the axes at the selected grasp, m."""


class LiveScene:
    """A cell drawn in a viser scene.

    Parameters
    ----------
    scene
        `viser.SceneApi`, typed as Any because viser is imported lazily.
    robot
        The simulated robot.
    """

    def __init__(self, scene: Any, robot: SimRobot) -> None:
        self._scene, self._data = scene, robot.data
        self._bodies = {
            body: scene.add_mesh_trimesh(f"/cell/{body}", shape)
            for body, shape in body_meshes(robot.model).items()
        }
        self._capture_count = 0
        self._capture: Any = None
        self._grasp: Any = None
        self._clouds: dict[int, Any] = {}
        self._solids: dict[int, list[Any]] = {}
        self._colours: dict[int, NDArray[np.uint8]] = {}
        self._show_cloud = self._show_solids = True
        self.move()

    def move(self) -> None:
        """Update the pose of every body."""
        for body, handle in self._bodies.items():
            handle.position = self._data.xpos[body].copy()
            handle.wxyz = self._data.xquat[body].copy()

    def show_capture(
        self,
        frame: DepthFrame,
        scene: Scene,
        plan: GraspPlan | None = None,
        colours: Mapping[int, int] | None = None,
    ) -> None:
        """Draw a capture: its points by object, the solids, and the selected grasp.

        Parameters
        ----------
        frame, scene
            The depth image and its scene.
        plan
            The selected grasp, if any.
        colours
            Colour number of each object by its label; default: the label.
        """
        self._remove_capture()
        numbers = colours or {}
        self._colours = {
            item.label: colour_of(numbers.get(item.label, item.label)) for item in scene.objects
        }
        # Each capture has its own parent node. A browser that receives messages out of order cannot
        # confuse two captures.
        self._capture_count += 1
        node = f"/capture{self._capture_count}"
        self._capture = self._scene.add_frame(node, show_axes=False)
        self._draw_points(node, frame, scene)
        for item in scene.objects:
            parts = fit_parts(item.fit) if item.fit else ()
            self._solids[item.label] = [
                handle
                for number, part in enumerate(parts)
                for handle in self._draw_solid(f"{node}/{item.label}/{number}", item.label, part)
            ]
        if plan:
            palm = preferred_palm(plan)
            self._grasp = self._scene.add_frame(
                f"{node}/grasp",
                axes_length=GRASP_AXES,
                axes_radius=0.03 * GRASP_AXES,
                position=palm.translation,
                wxyz=palm.rotation.as_quat(scalar_first=True),
            )

    def remove_object(self, label: int) -> None:
        """Remove the points and solids of an object, and the grasp."""
        gone = [*self._solids.pop(label, []), self._clouds.pop(label, None), self._grasp]
        self._grasp = None
        for handle in gone:
            if handle is not None:
                handle.remove()

    def show(self, *, cloud: bool, solids: bool) -> None:
        """Show or hide the points and the fitted solids."""
        self._show_cloud, self._show_solids = cloud, solids
        # Iterate over copies: the page calls this from another thread.
        for handle in list(self._clouds.values()):
            handle.visible = cloud
        for handle in [one for handles in list(self._solids.values()) for one in handles]:
            handle.visible = solids

    def _draw_points(self, node: str, frame: DepthFrame, scene: Scene) -> None:
        """Draw the points of each object, and the remaining points with label 0."""
        labels = scene.segmentation.labels
        grid = slice(None, None, CLOUD_STEP), slice(None, None, CLOUD_STEP)
        valid = frame.valid[grid]
        points = frame.points()[grid][valid].astype(np.float64)
        if frame.T_world_camera is not None:
            points = frame.T_world_camera.apply(points)
        point_labels = np.zeros(len(points), dtype=np.int64)
        if labels.shape == frame.depth.shape:
            point_labels = labels[grid][valid]
        known = [label for label in self._colours if (point_labels == label).any()]
        point_labels = np.where(np.isin(point_labels, known), point_labels, 0)
        near = points[:, 2] > -MAX_DEPTH_BELOW_TABLE
        for label in (0, *known):
            shown = near & (point_labels == label)
            if not shown.any():
                continue
            shade = self._colours.get(label, np.array(UNLABELLED, np.uint8))
            colours = np.tile(shade, (int(shown.sum()), 1))
            cloud = draw_points(
                self._scene, f"{node}/cloud{label}", points[shown], colours, POINT_SIZE
            )
            cloud.visible = self._show_cloud
            self._clouds[label] = cloud

    def _draw_solid(self, node: str, label: int, part: Superquadric) -> list[Any]:
        red, green, blue = self._colours[label].tolist()
        colour = red, green, blue
        drawn = [
            draw_mesh(self._scene, f"{node}/surface", mesh(part, RESOLUTION), colour, OPACITY),
            draw_lines(self._scene, f"{node}/lines", feature_curves(part), colour, 2.0),
        ]
        for handle in drawn:
            handle.visible = self._show_solids
        return drawn

    def _remove_capture(self) -> None:
        """Remove the nodes of the last capture."""
        if self._capture is not None:
            self._capture.remove()
        self._capture = self._grasp = None
        self._clouds, self._solids = {}, {}
