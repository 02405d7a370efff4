"""A local page server that prints nothing to the terminal."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from typing import Any

from eyehand.errors import InputError

from .page_guard import guarded

HOST = "127.0.0.1"
"""Address of the server. Only this machine can connect; from elsewhere use `ssh -L`."""
ANY_PORT = 0
"""Port number that selects any free port."""
MAX_PORT = 2**16 - 1


def open_server(port: int = ANY_PORT, title: str | None = None) -> Any:
    """Start a page server at a port, or at the next free one.

    Returns
    -------
    Any
        `viser.ViserServer`. Its type is Any because viser is imported only here.

    Raises
    ------
    InputError
        If the port number is invalid, or no port can be opened.
    """
    # With an invalid port, the thread of the server would end, and its caller would wait forever.
    if not ANY_PORT <= port <= MAX_PORT:
        raise InputError(f"the port of a page must be from {ANY_PORT} to {MAX_PORT}, got {port}")
    import viser

    try:
        # viser prints a greeting on stdout, which is reserved for --json.
        with (
            _guarded_sockets(),
            contextlib.redirect_stdout(io.StringIO()),
        ):
            return viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
    except (OSError, RuntimeError) as error:
        fault = " ".join(str(error).split())
        raise InputError(f"cannot serve a page at port {port}: {fault}") from error


def close_server(server: Any) -> None:
    """Stop the server."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


@contextlib.contextmanager
def _guarded_sockets() -> Iterator[None]:
    """Check the requests of servers that start meanwhile. viser has no option for it."""
    from websockets.asyncio import server

    sockets: Any = server
    serve = sockets.serve
    sockets.serve = guarded(serve)
    try:
        yield
    finally:
        sockets.serve = serve
