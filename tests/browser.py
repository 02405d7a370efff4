"""A headless Chromium for tests of pages, driven over its DevTools websocket."""

from __future__ import annotations

import base64
import contextlib
import json
import shutil
import subprocess
import time
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""Programs on PATH that are tried, in this order."""
OPTIONS = (
    "--headless=new",
    "--remote-debugging-port=0",
    "--no-sandbox",  # the sandbox does not start for root, as in containers
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--hide-scrollbars",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
)
ANSWER_S, LOAD_S = 120.0, 120.0
"""Time limits of an answer of the browser, and of a page that loads."""

LOOKS = ((390, False), (390, True), (1440, False), (1440, True))
"""Widths in px of a telephone and a wide screen, each light and dark."""
TWO_LOOKS = (LOOKS[0], LOOKS[3])
"""Looks for pages with a 3D view. It takes seconds without a graphics card."""


class Page:
    """A tab of the browser. It collects errors of the console and all requested addresses."""

    def __init__(self, socket: Any, session: str) -> None:
        self._socket, self._session, self._number = socket, session, 0
        self._loaded = False
        self.errors: list[str] = []
        self.requests: list[str] = []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command of the DevTools protocol and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        self._socket.send(json.dumps(message | {"sessionId": self._session}))
        end = time.monotonic() + ANSWER_S
        while True:
            answer = self._receive(end - time.monotonic())
            if answer.get("id") == self._number and answer.get("sessionId") == self._session:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]

    def open(self, address: str, *, width: int = 1440, dark: bool = False) -> None:
        """Load an address in a window of a width in px, and forget what former pages did."""
        self.errors, self.requests, self._loaded = [], [], False
        phone = width < 600
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=844 if phone else 900,
            deviceScaleFactor=1,
            mobile=phone,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        self.call("Page.navigate", url=address)
        end = time.monotonic() + LOAD_S
        while not self._loaded:
            self._receive(end - time.monotonic())

    def value(self, expression: str) -> Any:
        """Evaluate an expression of JavaScript in the page, awaiting promises."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Wait until an expression of JavaScript is true."""
        end = time.monotonic() + LOAD_S
        while not self.value(expression):
            assert time.monotonic() < end, f"never true: {expression}"
            time.sleep(0.1)

    def press(self, key: str, code: int) -> None:
        """Press and release a key: its name, and its virtual key code."""
        for what in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=what, key=key, windowsVirtualKeyCode=code)

    def screenshot(self, path: Path, *, whole: bool = False) -> None:
        """Write a PNG of the window, or of the whole page."""
        shot = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(shot["data"]))

    def _receive(self, timeout: float) -> dict[str, Any]:
        message = json.loads(self._socket.recv(timeout=max(timeout, 0.0)))
        event, parameters = message.get("method"), message.get("params", {})
        if event == "Page.loadEventFired":
            self._loaded = True
        elif event == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(parameters["exceptionDetails"]))
        elif event == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(one.get("value")) for one in parameters["args"]))
        elif event == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.errors.append(parameters["entry"]["text"])
        elif event == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif event == "Network.webSocketCreated":
            self.requests.append(parameters["url"])
        return message


@contextlib.contextmanager
def open_page(folder: Path) -> Iterator[Page]:
    """Start a browser with its profile in `folder`; skip the test where none is installed."""
    program = next((found for name in NAMES if (found := shutil.which(name))), None)
    if program is None:
        pytest.skip(f"no browser on PATH: none of {', '.join(NAMES)}")
    client = pytest.importorskip("websockets.sync.client", reason="websockets: extra view")
    command = [program, *OPTIONS, f"--user-data-dir={folder}", "about:blank"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        port, path = _devtools_address(folder / "DevToolsActivePort", process)
        with client.connect(
            f"ws://127.0.0.1:{port}{path}", max_size=None, compression=None
        ) as socket:
            yield _new_page(socket)
    finally:
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _devtools_address(file: Path, process: subprocess.Popen[bytes]) -> tuple[str, str]:
    """Return the port and the path of the browser's websocket, which it writes when it is ready."""
    end = time.monotonic() + LOAD_S
    while not (file.is_file() and len(lines := file.read_text().split()) == 2):
        assert process.poll() is None, f"the browser ended with exit code {process.returncode}"
        assert time.monotonic() < end, "the browser opened no port"
        time.sleep(0.05)
    return lines[0], lines[1]


def _new_page(socket: Any) -> Page:
    """Open a tab and attach to it."""

    def call(number: int, method: str, **parameters: Any) -> dict[str, Any]:
        socket.send(json.dumps({"id": -number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(socket.recv(timeout=ANSWER_S))
            if answer.get("id") == -number:
                return answer["result"]

    target = call(1, "Target.createTarget", url="about:blank")["targetId"]
    attached = call(2, "Target.attachToTarget", targetId=target, flatten=True)
    return Page(socket, attached["sessionId"])


def check_page(
    page: Page, address: str, looks: Sequence[tuple[int, bool]] = LOOKS, *, live: bool = False
) -> None:
    """Check a page on a telephone and a wide screen, light and dark.

    Parameters
    ----------
    page
        The tab of the browser.
    address
        Address of the page. All that it loads must come from there.
    looks
        Widths in px, and whether the browser asks for a dark page.
    live
        The page is a live page of viser, which chooses title and icons and is always light.
    """
    for width, dark in looks:
        page.open(address, width=width, dark=dark)
        page.wait_for("document.body.innerText.trim().length > 0")
        assert page.errors == []
        assert {_place(one) for one in page.requests} <= {_place(address), "data:", "blob:"}
        assert page.value("document.documentElement.scrollWidth") <= width
        assert page.value("document.documentElement.lang") == "en"
        if not live:
            assert page.value(UNNAMED) == []
            assert page.value("document.title") not in ("", "Viser")
            assert (page.value(BACKGROUND) < 128) is dark
        page.press("Tab", 9)
        assert page.value("document.activeElement !== document.body"), "Tab reaches nothing"


UNNAMED = (
    '[...document.querySelectorAll(\'img:not([alt]), img[alt=""], video:not([aria-label]), '
    "svg[role=img]:not([aria-label])')].map(one => one.outerHTML.slice(0, 80))"
)
"""Pictures and films without a text for those who do not see them."""
BACKGROUND = """(() => {
  for (const one of [document.body, document.documentElement]) {
    const parts = getComputedStyle(one).backgroundColor.match(/[\\d.]+/g).map(Number);
    if (parts.length < 4 || parts[3] > 0) return (parts[0] + parts[1] + parts[2]) / 3;
  }
  return matchMedia('(prefers-color-scheme: dark)').matches ? 0 : 255;
})()"""
"""Brightness of the page's background, 0 to 255; without one the browser's own."""


def _place(address: str) -> str:
    """Return the server of an address, or its kind if it has none."""
    parts = urlsplit(address)
    if parts.scheme in ("data", "blob"):
        return f"{parts.scheme}:"
    return parts.netloc or "file"
