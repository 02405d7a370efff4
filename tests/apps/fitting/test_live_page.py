"""The live page: its sliders and buttons change the solid and the residuals."""

import urllib.request

import numpy as np
import pytest
import viser

from eyehand.apps.fitting.live_page import LivePage
from eyehand.apps.fitting.page_server import ANY_PORT, close_server, open_server
from eyehand.apps.fitting.solid_page import page_html, write_page
from eyehand.errors import InputError

from ...browser import TWO_LOOKS, check_page


@pytest.fixture
def page(can, lens, unfit):
    served = LivePage([can, lens, unfit], ANY_PORT)
    yield served
    served.close()


def off(page) -> float:
    return float(np.mean(np.abs(page.residuals)))


def test_page_responds_and_stdout_is_empty(page, capfd):
    with urllib.request.urlopen(page.address, timeout=5) as answer:
        assert answer.status == 200
        assert b"viser" in answer.read().lower()
    page.close()
    assert capfd.readouterr().out == ""


def test_every_slider_moves_the_surface_away_from_the_points(page):
    assert len(page.sliders) == 13
    fitted = off(page)
    for name, slider in page.sliders.items():
        before = slider.value
        slider.value = 2.0 * before if name[0] == "a" else 40.0 if name[0] in "rc" else 0.6
        if name != "rz":  # a can turned about its axis is the same can
            assert off(page) > 2.0 * fitted, name
        slider.value = before
        assert off(page) == pytest.approx(fitted, rel=0.05)


def test_buttons_load_the_candidate_solids(page, can):
    page.sliders["a3"].value = 30.0
    assert len(page.kind_buttons) == len(can.fit.candidates) > 1
    first, second = list(page.kind_buttons.values())[:2]
    for button, candidate in ((second, can.fit.candidates[1]), (first, can.fit.candidates[0])):
        for callback in button._impl.update_cb:
            callback(None)
        assert page.solids[0].kind == candidate.kind
        assert page.solids[0].semi_axes == pytest.approx(candidate.superquadric.semi_axes)


def test_list_selects_another_cloud_also_without_a_solid(page, lens):
    page.select("lens.xyz")
    assert page.solids[0].semi_axes == pytest.approx(lens.fit.superquadric.semi_axes)
    assert len(page.residuals) == len(lens.cloud.points)
    page.select("mist.xyz")
    assert page.solids == ()
    page.select("can.ply")
    assert len(page.solids) == 1


def test_sliders_edit_the_selected_part(hammer):
    page = LivePage([hammer], ANY_PORT)
    try:
        block, stick = page.solids
        page.part.value = "part 2: cylinder"
        assert page.sliders["a3"].value == pytest.approx(200.0)
        page.sliders["a3"].value = 100.0
        assert page.solids[0] is block
        assert page.solids[1].semi_axes == pytest.approx([0.012, 0.012, 0.05])
        assert off(page) > 1e-3
        for callback in page.kind_buttons["as fitted"]._impl.update_cb:
            callback(None)
        assert page.solids == (block, stick)
    finally:
        page.close()


def test_port_in_use_is_skipped(can):
    taken = open_server()
    try:
        page = LivePage([can], taken.get_port())
        assert str(taken.get_port()) not in page.address
        page.close()
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
    page = LivePage([can], ANY_PORT)
    try:
        check_page(browser, page.address, TWO_LOOKS, live=True)
        browser.wait_for("document.body.innerText.includes('cylinder')")
    finally:
        page.close()


def test_foreign_site_opens_no_websocket_of_a_live_page(can, browser, tmp_path):
    page = LivePage([can], ANY_PORT)
    try:
        (tmp_path / "evil.html").write_text("<title>evil</title>")
        browser.open((tmp_path / "evil.html").as_uri())
        answer = browser.value(
            f"new Promise(done => {{const one = new WebSocket('ws{page.address[4:]}', "
            f"'viser-v{viser.__version__}');"
            "one.onopen = () => done('opened'); one.onerror = () => done('refused')})"
        )
        assert answer == "refused"
    finally:
        page.close()
