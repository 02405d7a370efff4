"""Write fits as one self-contained HTML file with a 3D view; no server or network is needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..drawn_solids import drawn_solids
from ..output_files import write_text
from .page_scene import PageScene, starting_camera
from .page_server import close_server, open_server
from .picture_scene import picture_views
from .solid_text import headline
from .viewer_page import viewer_html

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from .fit_inputs import FittedCloud

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
    server = open_server()
    try:
        _draw(server, fits)
        lines = [f"{one.cloud.stem}: {', '.join(headline(one.fit))}" for one in fits]
        return viewer_html(server, "Fitted solids", lines)
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
        drawn = PageScene(server.scene, node, fitted.cloud, place)
        drawn.draw(drawn_solids(fitted.fit))
        server.scene.add_label(
            f"{node}/name",
            fitted.cloud.stem,
            position=tuple(ABOVE * up),
            font_size_mode="scene",
            font_scene_height=LETTERS,
            anchor="bottom-center",
        )
    # One cloud has the viewpoint of the live page. Several are seen from the front.
    if len(fits) > 1:
        position = 0.3 * wide * up + (1.5 + 0.55 * wide) * front.towards
    server.initial_camera.position = tuple(position)
    server.initial_camera.look_at = (0.0, 0.0, 0.0)
