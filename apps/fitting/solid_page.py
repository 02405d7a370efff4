"""Show fits on a page with a 3D view: served live, or written as one self-contained file."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench.chart_style import GREY, INK
from ..drawn_solids import drawn_solids, solid_curves, solid_mesh
from ..output_files import write_text
from .page_server import ANY_PORT, HOST, close_server, open_server
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
from .solid_text import headline
from .viewer_page import draw_lines, draw_mesh, draw_points, viewer_html

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    from eyehand.perception import Superquadric
    from eyehand.perception.superquadric import Vessel

    from .fit_inputs import Cloud, FittedCloud


TITLE = "Fitted solids"
APART = 2.6
"""Distance between neighbouring clouds, in half diagonals."""
ABOVE, LETTERS = 1.2, 0.13
"""Height of a name above the middle of its cloud, and its letter height, in half diagonals."""


def write_page(path: Path, fits: Sequence[FittedCloud]) -> None:
    """Write clouds and solids side by side as one HTML file, atomically.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    write_text(path, page_html(fits))


def page_html(fits: Sequence[FittedCloud]) -> str:
    """Return the text of the file, about 1.5 MB: the viewer of viser and the scene."""
    # The serialiser of viser needs a running server. Its address is not printed.
    with _drawn_fits(fits) as server:
        return viewer_html(server, TITLE, _lines(fits))


@contextmanager
def served_page(fits: Sequence[FittedCloud], port: int) -> Iterator[str]:
    """Serve clouds and solids side by side within the context; return the address of the page.

    Parameters
    ----------
    fits
        Fits to show, at least one.
    port
        Port of the server. If it is in use, the next free port is taken.

    Raises
    ------
    InputError
        If no port can be opened.
    """
    with _drawn_fits(fits, port) as server:
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.add_markdown("\n".join(f"- {line}" for line in _lines(fits)))
        yield f"http://{HOST}:{server.get_port()}"


def _lines(fits: Sequence[FittedCloud]) -> list[str]:
    lines = [f"{one.cloud.stem}: {', '.join(headline(one.fit))}" for one in fits]
    return [*lines, "points: blue inside the solid, grey on its surface, orange outside"]


@contextmanager
def _drawn_fits(fits: Sequence[FittedCloud], port: int = ANY_PORT) -> Iterator[Any]:
    server = open_server(port, TITLE)
    try:
        _draw(server, fits)
        yield server
    finally:
        close_server(server)


def _draw(server: Any, fits: Sequence[FittedCloud]) -> None:
    first = fits[0].cloud
    front, _, _ = picture_views(first)
    position, up = starting_camera(first)
    server.scene.set_up_direction(tuple(up))
    wide = APART * (len(fits) - 1)
    for number, fitted in enumerate(fits):
        place = (APART * number - wide / 2) * front.right
        node = f"/{number + 1}"
        draw_cloud(server.scene, node, fitted.cloud, drawn_solids(fitted.fit), place)
        server.scene.add_label(
            f"{node}/name",
            fitted.cloud.stem,
            position=tuple(ABOVE * up),
            font_size_mode="scene",
            font_scene_height=LETTERS,
            anchor="bottom-center",
        )
    # Several clouds are seen from the front.
    if len(fits) > 1:
        position = 0.3 * wide * up + (1.5 + 0.55 * wide) * front.towards
    server.initial_camera.position = tuple(position)
    server.initial_camera.look_at = (0.0, 0.0, 0.0)


MAX_POINTS = 4000
"""Maximum number of points. More would cover one another."""
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


def draw_cloud(
    scene: Any,
    node: str,
    cloud: Cloud,
    parts: Sequence[Superquadric | Vessel],
    place: ArrayLike = (0, 0, 0),
) -> None:
    """Draw a cloud with its solids, support and camera under a node of a viser scene.

    Coordinates are scaled about the middle of the cloud so that its half diagonal is 1, because
    browsers use single precision and clip near geometry. The points are coloured by their distance
    to the solids.

    Parameters
    ----------
    scene
        `viser.SceneApi`. Its type is Any because viser is imported only to make a page.
    node
        Name of the node that holds everything.
    cloud
        Cloud to show.
    parts
        Its solids, or none.
    place
        Position (3,) of the middle of the cloud, in half diagonals.
    """
    points = thinned(cloud.points, MAX_POINTS)
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    middle = 0.5 * (low + high)
    reach = max(float(np.linalg.norm(high - low)) / 2, 1e-6)

    def scaled(at: NDArray[np.float64]) -> NDArray[np.float32]:
        return ((at - middle) / reach).astype(np.float32)

    scene.add_frame(node, show_axes=False, position=np.asarray(place, dtype=np.float64))
    _, residuals = residual_to(points, parts)
    limit = colour_limit_mm(residuals) if parts else 0.0
    colours = np.round(255 * residual_colours(residuals, limit)).astype(np.uint8)
    draw_points(scene, f"{node}/cloud", scaled(points), colours, POINT_SIZE)
    for number, part in enumerate(parts):
        vertices, faces = solid_mesh(part, RESOLUTION)
        surface = scaled(vertices), faces
        draw_mesh(scene, f"{node}/solid {number}", surface, rgb(SOLID), SOLID_OPACITY)
        curves = [scaled(curve) for curve in solid_curves(part)]
        draw_lines(scene, f"{node}/lines {number}", curves, rgb(INK), CURVE_PIXELS)
    if cloud.support_plane is not None:
        square = scaled(_support_square(cloud, middle, reach)), np.array([[0, 2, 1], [0, 3, 2]])
        draw_mesh(scene, f"{node}/support", square, rgb(GREY), 0.18, side="double")
    if cloud.view_origin is not None:
        eye = scaled(cloud.view_origin)
        eye = eye * min(MAX_CAMERA_DISTANCE / max(float(np.linalg.norm(eye)), 1e-6), 1.0)
        scene.add_icosphere(f"{node}/camera", radius=0.04, color=rgb(INK), position=eye)
        scene.add_label(f"{node}/camera/name", "camera")


def _support_square(cloud: Cloud, middle: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Return the corners (4, 3), m, of the part of the support plane that is drawn."""
    plane = cloud.support_plane
    assert plane is not None
    foot = middle - (plane[:3] @ middle + plane[3]) * plane[:3]
    front, _, _ = picture_views(cloud)
    corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    return foot + SUPPORT_REACH * reach * corners @ np.array([front.right, front.towards])


def starting_camera(cloud: Cloud) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the initial camera position (3,), in half diagonals, and the up direction (3,)."""
    front, _, _ = picture_views(cloud)
    axes = np.array([front.right, front.up, front.towards])
    return np.array(VIEW_FROM) @ axes, up_direction(cloud)
