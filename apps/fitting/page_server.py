"""A local page server that prints nothing to the terminal."""

from __future__ import annotations

import contextlib
import io
from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

HOST = "127.0.0.1"
"""Only this machine may look; elsewhere `ssh -L` brings the page."""
ANY_PORT = 0
MOST_PORT = 2**16 - 1
"""Ports are 16 bits."""


def open_server(port: int = ANY_PORT, title: str | None = None) -> Any:
    """Serve a page at a port, or at the next free one; by default at any.

    Returns
    -------
    Any
        `viser.ViserServer`, typed as Any because viser is loaded only here.

    Raises
    ------
    InputError
        If there is no such port, or none can be opened there.
    """
    # The server's own thread would die of it, and whoever waits for its page waits for ever.
    if not ANY_PORT <= port <= MOST_PORT:
        raise InputError(f"a page's port must be from {ANY_PORT} to {MOST_PORT}, got {port}")
    import viser

    try:
        # viser always prints a greeting on stdout, which belongs to --json.
        with _silent():
            return viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
    except (OSError, RuntimeError) as error:
        fault = " ".join(str(error).split())
        raise InputError(f"cannot serve a page at port {port}: {fault}") from error


def close_server(server: Any) -> None:
    """Stop serving."""
    with _silent():
        server.stop()


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()):
        yield
