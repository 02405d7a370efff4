"""Show fits on a page with a 3D view: served live, or written as one self-contained file."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ..drawn_solids import drawn_solids
from ..output_files import write_text
from .page_scene import draw_cloud, starting_camera
from .page_server import ANY_PORT, HOST, close_server, open_server
from .picture_scene import picture_views
from .solid_text import headline
from .viewer_page import viewer_html

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from .fit_inputs import FittedCloud

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


def wait_for_interrupt() -> None:
    """Return at Ctrl-C."""
    try:
        while True:
            time.sleep(3600.0)
    except KeyboardInterrupt:
        pass


def _lines(fits: Sequence[FittedCloud]) -> list[str]:
    return [f"{one.cloud.stem}: {', '.join(headline(one.fit))}" for one in fits]


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
