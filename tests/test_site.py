"""The documentation site: generated pages are complete, and it builds without warnings, offline."""

import os
import re
import runpy
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from eyehand.apps.command_table import COMMANDS

from .browser import check_page

ROOT = Path(__file__).resolve().parents[1]
HOOK = runpy.run_path(str(ROOT / "docs" / "generated_pages.py"))


def test_page_of_commands_describes_all_commands_and_options():
    page = HOOK["commands_page"]()
    for command in COMMANDS:
        assert f"\n## eyehand {command}\n" in page
    assert "| `--calibration-error` | Standard deviation of the gripper's position" in page
    assert "| `--scene`, `--family` | Arrangement of the objects" in page
    assert "| `--seed` | Seed of the scene and of the camera's noise. | `0` |" in page
    assert "| `--video`, `--no-video` | Record the film. | on |" in page
    # Options of a group, and a choice.
    assert "| `--arm` | " in page
    assert "One of `lift`, `move`, `hand-over`, `use`. | `lift` |" in page


def test_pages_of_python_describe_all_public_names():
    pages = HOOK["pages"]()
    assert "[`perceive`](python/perception.md#perceive)" in pages["python.md"]
    packages = {name: text for name, text in pages.items() if name.startswith("python/")}
    assert "\n## perceive\n" in packages["python/perception.md"]
    assert "\n## ApproachController\n" in packages["python/control.md"]
    assert sum(text.count("\n## ") for text in packages.values()) > 200
    # A field, a method, and a member of a protocol.
    everything = "".join(packages.values())
    assert "| `max_extent` | " in everything
    assert "| `distance()` | " in everything


def test_page_of_files_describes_all_members():
    page = HOOK["files_page"]()
    assert "| `objects` | array of [object](#object) | The objects, the largest first. |" in page
    assert "| `rim.semi_axes_m` | array of 2 number | Semi-axes, m. |" in page
    assert "| `spread_m` | number or null | Robust standard deviation" in page
    assert "to the world (z up). Optional. |" in page


def test_page_of_examples_shows_all_scripts():
    page = HOOK["examples_page"]()
    assert page.count("```python") == len(list((ROOT / "examples").glob("*.py")))


def test_every_page_is_in_the_navigation():
    listed = set(re.findall(r": ([\w/.]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE))
    docs = ROOT / "docs"
    written = {path.relative_to(docs).as_posix() for path in docs.rglob("*.md")}
    assert listed == written | set(HOOK["pages"]())


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Build the site and return its folder."""
    if find_spec("mkdocs") is None:
        pytest.skip("mkdocs is not installed: extra docs")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def test_site_builds_without_warnings_and_loads_nothing_from_other_servers(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 25
    for page in pages:
        loaded = re.findall(r'<(?:script|img|link)[^>]*(?:src|href)="([^"]*)"', page.read_text())
        assert not [address for address in loaded if "//" in address], page.name


@pytest.mark.parametrize(
    "name", ["index", "commands", "results", "gallery", "guides/perceive", "python/control"]
)
def test_pages_of_the_site_work_in_a_browser(site, browser, name):
    check_page(browser, (site / f"{name}.html").as_uri())


def test_search_finds_pages_without_a_server(site, browser):
    browser.open((site / "index.html").as_uri())
    browser.value("document.querySelector('[name=query]').focus()")
    browser.value(
        "(() => { const field = document.querySelector('[name=query]'); field.value = 'calibrate';"
        "field.dispatchEvent(new KeyboardEvent('keyup')); })()"
    )
    browser.wait_for("document.querySelectorAll('.md-search-result__item').length > 0")
    assert "Calibrate the camera's pose" in browser.value(
        "document.querySelector('.md-search-result__list').innerText"
    )
    assert browser.errors == []
    assert all(address.startswith(("file:", "data:")) for address in browser.requests)
