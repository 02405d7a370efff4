"""A live page answers its own browser tab and nobody else."""

import asyncio

import pytest

pytest.importorskip("viser", reason="live pages need the extra [view]")
import viser
import websockets

from eyehand.apps.fitting.page_server import close_server, is_local, open_server


@pytest.fixture(scope="module")
def port():
    server = open_server()
    yield server.get_port()
    close_server(server)


async def first_bytes(port, origin, sent=None) -> int:
    """Connect, send a message, and return the size of the first message of the page."""
    async with websockets.connect(
        f"ws://127.0.0.1:{port}",
        origin=origin,
        subprotocols=[websockets.Subprotocol(f"viser-v{viser.__version__}")],
    ) as connection:
        if sent is not None:
            await connection.send(sent)
            await asyncio.wait_for(connection.wait_closed(), 10.0)
            return connection.close_code or 0
        return len(await asyncio.wait_for(connection.recv(), 10.0))


def test_the_page_itself_is_served(port):
    assert asyncio.run(first_bytes(port, f"http://127.0.0.1:{port}")) > 0


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_foreign_site_is_refused(port, origin):
    with pytest.raises(websockets.InvalidStatus, match="403"):
        asyncio.run(first_bytes(port, origin))


@pytest.mark.parametrize("sent", ["text", b"\xff\xfe\x00", b"\x81\xa1a\x01", b"\x93\x01\x02\x03"])
def test_malformed_message_closes_without_traceback(port, sent, capfd, caplog):
    assert asyncio.run(first_bytes(port, f"http://127.0.0.1:{port}", sent)) == 1003
    assert "Traceback" not in capfd.readouterr().err + caplog.text
    assert asyncio.run(first_bytes(port, f"http://127.0.0.1:{port}")) > 0


@pytest.mark.parametrize(
    ("host", "origin", "expected"),
    [
        ("127.0.0.1:8080", None, True),
        ("localhost:8080", "http://localhost:8080", True),
        ("[::1]:8080", "http://[::1]:8080", True),
        ("localhost:8080", "http://localhost:9090", False),
        ("rebound.example:8080", None, False),
        ("rebound.example:8080", "http://rebound.example:8080", False),
        (None, None, False),
    ],
)
def test_requests_are_checked_by_host_and_origin(host, origin, expected):
    assert is_local(host, origin) is expected
