"""Pages of fits: served live, and as files that contain everything."""

import urllib.request

import pytest
import viser

from eyehand.apps.fitting.page_server import ANY_PORT, close_server, open_server
from eyehand.apps.fitting.solid_page import page_html, served_page, write_page
from eyehand.errors import InputError

from ...browser import TWO_LOOKS, check_page


def test_live_page_responds_and_stdout_is_empty(can, hammer, unfit, capfd):
    with (
        served_page([can, hammer, unfit], ANY_PORT) as address,
        urllib.request.urlopen(address, timeout=5) as answer,
    ):
        assert answer.status == 200
        assert b"viser" in answer.read().lower()
    assert capfd.readouterr().out == ""


def test_port_in_use_is_skipped(can):
    taken = open_server()
    try:
        with served_page([can], taken.get_port()) as address:
            assert str(taken.get_port()) not in address
    finally:
        close_server(taken)


def test_file_contains_the_whole_page(can, lens, tmp_path):
    html = page_html([can, lens])
    assert html.lower().startswith("<!doctype html")
    assert "__VISER_EMBED_DATA__" in html
    assert 3e5 < len(html) < 5e6
    with pytest.raises(InputError, match="no folder"):
        write_page(tmp_path / "none" / "page.html", [can])


def test_file_shows_its_text_in_a_browser(can, lens, browser, tmp_path):
    write_page(tmp_path / "page.html", [can, lens])
    check_page(browser, (tmp_path / "page.html").as_uri(), TWO_LOOKS)
    browser.wait_for("document.querySelector('canvas[data-engine]') !== null")
    text = browser.value("document.body.innerText")
    assert "can: cylinder, 80.0 × 80.0" in text
    assert "lens: superquadric" in text


def test_live_page_works_in_a_browser(can, browser):
    with served_page([can], ANY_PORT) as address:
        check_page(browser, address, TWO_LOOKS, live=True)
        browser.wait_for("document.body.innerText.includes('cylinder')")


def test_foreign_site_opens_no_websocket_of_a_live_page(can, browser, tmp_path):
    with served_page([can], ANY_PORT) as address:
        (tmp_path / "evil.html").write_text("<title>evil</title>")
        browser.open((tmp_path / "evil.html").as_uri())
        answer = browser.value(
            f"new Promise(done => {{const one = new WebSocket('ws{address[4:]}', "
            f"'viser-v{viser.__version__}');"
            "one.onopen = () => done('opened'); one.onerror = () => done('refused')})"
        )
        assert answer == "refused"
