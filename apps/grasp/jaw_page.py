"""Write the grasps of a frame as one self-contained HTML page with a 3D view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.perception.superquadric import feature_curves, mesh

from ..fitting.page_server import close_server, open_server
from ..fitting.viewer_page import draw_lines, draw_mesh, draw_points, viewer_html
from ..scene_json import fit_parts
from ..scene_picture import colour_of
from .jaw_shapes import CORNERS, FACES, DrawnGrasp, drawn_grasps
from .jaw_table import object_notes
from .view_scene import nearby_points, view_axes, viewed_points

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .jaw_frame import GraspedFrame

INK = (34, 38, 43)
OPACITY, PALM_OPACITY = 0.45, 0.12
POINT_SIZE = 0.006
"""Side of a point, relative to half the diagonal of the objects."""
LETTERS = 0.07
"""Height of the numbers of grasps, relative to half the diagonal of the objects."""
VIEW_DISTANCE = 2.6
"""Distance of the initial viewpoint, in half diagonals of the objects."""
RESOLUTION = 48
"""Points around a drawn solid."""
TRIANGLES = np.array([[a, b, c] for face in FACES for a, b, c in (face[:3], (face[0], *face[2:]))])
"""Triangles (12, 3) of a box."""


def page_html(found: GraspedFrame) -> str:
    """Return the text of the page, about 2 MB: the viewer of viser and the scene."""
    # The serialiser of viser needs a running server. Its address is not printed.
    server = open_server()
    try:
        drawn = _draw(server, found)
        title = f"Grasps of {Path(found.source).name}: {found.hand.name}"
        return viewer_html(server, title, _lines(found, drawn))
    finally:
        close_server(server)


def _draw(server: Any, found: GraspedFrame) -> list[DrawnGrasp]:
    """Draw points, solids and grippers, and return the drawn grasps.

    The half diagonal of the objects is 1 in the page.
    """
    points, colours = nearby_points(found)
    extent = viewed_points(found) if found.scene.objects else points
    low, high = np.percentile(extent, [0.5, 99.5], axis=0)
    middle, reach = 0.5 * (low + high), max(0.5 * float(np.linalg.norm(high - low)), 1e-3)

    def scaled(places: NDArray[np.float64]) -> NDArray[np.float32]:
        return ((places - middle) / reach).astype(np.float32)

    axes = view_axes(found)
    up = _vertical(found)
    server.scene.set_up_direction(tuple(up))
    draw_points(server.scene, "/points", scaled(points), colours, POINT_SIZE)
    for item in found.scene.objects:
        for number, solid in enumerate(fit_parts(item.fit) if item.fit else ()):
            vertices, faces = mesh(solid, RESOLUTION)
            node = f"/object {item.label}/{number}"
            red, green, blue = colour_of(item.label).tolist()
            draw_mesh(server.scene, node, (scaled(vertices), faces), (red, green, blue), OPACITY)
            curves = [scaled(curve) for curve in feature_curves(solid)]
            draw_lines(server.scene, f"{node}/lines", curves, INK, 1.5)
    drawn = drawn_grasps(found)
    for one in drawn:
        _draw_grasp(server.scene, one, one is drawn[0], scaled)
    server.initial_camera.position = tuple(VIEW_DISTANCE * axes[2])
    server.initial_camera.look_at = (0.0, 0.0, 0.0)
    return drawn


def _draw_grasp(scene: Any, one: DrawnGrasp, with_palm: bool, scaled: Any) -> None:
    node = f"/grasp {one.rank}"

    def boxes(corners: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
        """Return the surfaces of boxes (K, 8, 3) as one mesh."""
        faces = [TRIANGLES + len(CORNERS) * k for k in range(len(corners))]
        return scaled(corners.reshape(-1, 3)), np.concatenate(faces)

    draw_mesh(scene, f"{node}/fingers", boxes(one.fingers), one.colour, None, flat_shading=True)
    if with_palm and len(one.palm):
        draw_mesh(scene, f"{node}/palm", boxes(one.palm), one.colour, PALM_OPACITY)
    draw_lines(scene, f"{node}/lines", [scaled(one.fork), scaled(one.stem)], one.colour, 3.0)
    scene.add_label(
        f"{node}/rank",
        str(one.rank),
        position=tuple(scaled(one.stem[0]).tolist()),
        font_size_mode="scene",
        font_scene_height=LETTERS,
    )


def _lines(found: GraspedFrame, drawn: list[DrawnGrasp]) -> list[str]:
    """Return a line of text for each drawn grasp, each object without one, and each warning."""
    lines = [
        f"{one.rank}: object {one.grasp.object_label}, {1e3 * one.grasp.object_width:.0f} mm wide, "
        f"{one.grasp.side}, at {' '.join(f'{1e3 * x:.0f}' for x in one.grasp.position)} mm, "
        f"{100 * one.grasp.success:.0f} %"
        + ("" if one.grasp.safe else f", forbidden: {'; '.join(one.grasp.forbidden_by)}")
        for one in drawn
    ]
    if not drawn:
        lines.append(found.grasps.reason)
    elif len(drawn[0].palm):
        lines.append(f"the pale box is the palm of grasp {drawn[0].rank}")
    warnings = [f"warning: {one.message}" for one in found.scene.warnings]
    return lines + object_notes(found) + warnings


def _vertical(found: GraspedFrame) -> NDArray[np.float64]:
    """Return the direction up that the view of the page keeps, (3,)."""
    axes = view_axes(found)
    if found.scene.support is not None:
        return found.scene.support.normal
    return axes[1]
