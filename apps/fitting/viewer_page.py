"""Pages with a 3D view and its text: what they draw, and their form as one file.

A page suits screens of all sizes, light and dark. Scenes are of type Any, because viser is imported
only where a server is opened.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

STYLE = """
  :root { color-scheme: light dark; }
  body { margin: 0; font: 15px/1.5 system-ui, sans-serif; }
  h1 { font-size: 17px; margin: 0 0 4px; }
  ul { list-style: none; margin: 0; padding: 0; }
  #text { box-sizing: border-box; padding: 14px 18px; width: 24em; height: 100vh; overflow: auto; }
  #root { position: absolute; top: 0; left: 24em; width: calc(100% - 24em) !important; }
  /* On a narrow screen the view is almost square. Else its sides would be cut off. */
  @media (max-aspect-ratio: 1) {
    #root { position: static; width: 100% !important; height: 90vw !important; }
    #text { width: auto; height: auto; }
  }
"""
LIGHT = "{darkMode:false}"
BY_BROWSER = '{darkMode:matchMedia("(prefers-color-scheme: dark)").matches}'
"""Settings of the viewer in the page: as viser writes them, and chosen by the reader's browser."""


def viewer_html(server: Any, title: str, lines: Sequence[str]) -> str:
    """Return a page with the scene of a viser server, a title and lines of text.

    Parameters
    ----------
    server
        The running `viser.ViserServer`.
    title
        Title in plain text.
    lines
        Lines in plain text that say what the view shows.
    """
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    text = f'<div id="text"><h1>{escape(title)}</h1><ul>{items}</ul></div>'
    page = server.scene.as_html().replace(LIGHT, BY_BROWSER, 1)
    for mark, instead in (
        ("<title>Viser</title>", f"<title>{escape(title)}</title>"),
        ("</head>", f"<style>{STYLE}</style></head>"),
        ('<div id="root">', f'{text}<div id="root" role="region" aria-label="3D view">'),
    ):
        before, found, after = page.rpartition(mark)
        assert found, f"viser writes other pages: no {mark}"
        page = before + instead + after
    return page


def draw_points(
    scene: Any, node: str, points: NDArray[np.floating], colours: NDArray[np.uint8], size: float
) -> Any:
    """Draw points (N, 3) with their colours (N, 3) as discs of a diameter, and return the node."""
    return scene.add_point_cloud(
        node,
        points.astype(np.float32),
        colours,
        point_size=size,
        point_shape="circle",
        point_shading="flat",
        precision="float32",
    )


def draw_mesh(
    scene: Any,
    node: str,
    surface: tuple[NDArray[np.floating], NDArray[np.integer]],
    colour: tuple[int, int, int],
    opacity: float | None,
    **style: Any,
) -> Any:
    """Draw a mesh, vertices (V, 3) and faces (T, 3), without shadows, and return the node."""
    vertices, faces = surface
    return scene.add_mesh_simple(
        node,
        vertices.astype(np.float32),
        faces.astype(np.uint32),
        color=colour,
        opacity=opacity,
        cast_shadow=False,
        receive_shadow=False,
        **style,
    )


def draw_lines(
    scene: Any,
    node: str,
    curves: Sequence[NDArray[np.floating]],
    colour: tuple[int, int, int],
    pixels: float,
) -> Any:
    """Draw curves (K, 3) as lines of a width in px, and return the node."""
    segments = [np.stack([curve[:-1], curve[1:]], axis=1) for curve in curves]
    return scene.add_line_segments(
        node,
        np.concatenate(segments).astype(np.float32),
        colour,
        thickness=pixels,
        thickness_units="screen",
    )
