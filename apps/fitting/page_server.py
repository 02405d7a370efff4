"""A local page server that prints nothing to the terminal, and answers no foreign web sites.

A browser sends requests of any site to a local server. Without a check, a foreign site could read a
page and press its buttons.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Awaitable, Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

from eyehand.errors import InputError

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
        with _guarded_sockets(), contextlib.redirect_stdout(io.StringIO()):
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


LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
"""Names under which a browser may reach the page, also through `ssh -L`."""
FORBIDDEN = 403
UNSUPPORTED_DATA = 1003
"""Code of RFC 6455 that closes a connection after data of the wrong type."""


def guarded(serve: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap `websockets.asyncio.server.serve`: refuse foreign sites, and end at malformed data."""

    def guarded_serve(handler: Callable[[Any], Awaitable[None]], *args: Any, **options: Any) -> Any:
        answer = options.pop("process_request")

        def check(connection: Any, request: Any) -> Any:
            if not is_local(request.headers.get("Host"), request.headers.get("Origin")):
                return connection.respond(FORBIDDEN, "This page is only for its own browser tab.\n")
            return answer(connection, request)

        async def handle(connection: Any) -> None:
            from websockets import ConnectionClosed

            try:
                await handler(connection)
            except ConnectionClosed:
                raise
            # The handler decodes messages without checks, and raises many types of exceptions.
            except Exception:
                await connection.close(UNSUPPORTED_DATA, "malformed message")

        return serve(handle, *args, process_request=check, **options)

    return guarded_serve


def is_local(host: str | None, origin: str | None) -> bool:
    """Report whether a request comes from the page itself, or from a program on this machine.

    Parameters
    ----------
    host
        Header ``Host``: the address that the browser connects to. A foreign name that resolves to
        this machine is refused.
    origin
        Header ``Origin``: the page that sends the request; None for a page that is being opened.
    """
    if host is None or urlsplit(f"//{host}").hostname not in LOCAL_NAMES:
        return False
    return origin is None or urlsplit(origin).netloc == host
