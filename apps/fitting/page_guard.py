"""Protection of a local page against web sites that the same browser shows.

A browser sends requests of any site to a local server. Without this check, a foreign site could
read a page and press its buttons.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any
from urllib.parse import urlsplit

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
